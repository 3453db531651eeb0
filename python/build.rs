//! What a linker must be told on some systems: the interpreter's symbols are found when it loads the module.

fn main() {
    pyo3_build_config::add_extension_module_link_args();
}
