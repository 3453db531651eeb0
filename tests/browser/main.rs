//! The pages that Lacuna writes, in a real browser. Without a Chromium the test says so and passes;
//! `LACUNA_CHROMIUM` names the binary where it is not on the path.

mod chromium;
mod pointer;
mod tab;

use chromium::Chromium;
use data_encoding::BASE64;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;
use tab::Tab;

/// Widths of a phone and of a desk, in pixels.
const WIDTHS: [u32; 2] = [400, 1400];
const LOOK: &str = include_str!("look.js");

/// The folder of the pages, written once.
static PAGES: LazyLock<PathBuf> = LazyLock::new(pages);

#[test]
fn pages_can_be_read_in_a_browser() {
    let Some(chromium) = Chromium::found() else { return };
    for page in ["report.html", "compare.html"] {
        let complaints = look_at(&mut chromium.tab(), &PAGES.join(page));
        assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
    }
}

/// Figures tell their values to a pointer and to a keyboard; a recording can be chosen.
#[test]
fn figures_answer_a_pointer_and_keys() {
    let Some(chromium) = Chromium::found() else { return };
    let mut tab = chromium.tab();
    for page in ["report.html", "compare.html"] {
        let file = PAGES.join(page);
        for width in WIDTHS {
            let mut look = Look { tab: &mut tab, file: &file, complaints: vec![] };
            look.load(width);
            let found = [pointer::pointer(look.tab), pointer::keyboard(look.tab)].concat();
            look.complain(&format!("{width} px"), found);
            if page == "compare.html" {
                let found = pointer::choice(look.tab);
                look.complain(&format!("{width} px"), found);
            }
            let troubles = look.tab.troubles(&file);
            look.complain("after use", troubles);
            assert!(look.complaints.is_empty(), "\n{}", look.complaints.join("\n"));
        }
    }
}

/// A page that swallows what its reader does.
#[test]
fn a_figure_that_does_not_answer_is_seen() {
    let Some(chromium) = Chromium::found() else { return };
    let page = std::fs::read_to_string(PAGES.join("compare.html")).unwrap();
    let file = PAGES.join("deaf.html");
    std::fs::write(&file, page.replace("<main>", &format!("{DEAF}<main>"))).unwrap();
    let mut tab = chromium.tab();
    tab.load(&file);
    std::fs::remove_file(&file).unwrap();
    let said = [pointer::pointer(&mut tab), pointer::keyboard(&mut tab), pointer::choice(&mut tab)];
    let expected = ["no values under the pointer", "arrow keys lead to", "expected ["];
    for (found, expected) in said.iter().zip(expected) {
        assert!(found.iter().any(|c| c.starts_with(expected)), "{expected}: {found:#?}");
    }
}

const DEAF: &str = r#"
<script>
for (const kind of ["pointermove", "keydown", "change"]) {
  addEventListener(kind, (e) => e.stopImmediatePropagation(), true);
}
</script>
"#;

/// A page with everything wrong that this test is for: each is complained of.
#[test]
fn what_is_wrong_with_a_page_is_seen() {
    let Some(chromium) = Chromium::found() else { return };
    let page = std::fs::read_to_string(PAGES.join("report.html")).unwrap();
    let file = PAGES.join("broken.html");
    std::fs::write(&file, page.replace("</main>", &format!("{BROKEN}</main>"))).unwrap();
    let complaints = look_at(&mut chromium.tab(), &file);
    std::fs::remove_file(&file).unwrap();
    for expected in [
        "400 px: console: ",
        "400 px: exception: ",
        "400 px: request: ",
        "400 px: the page is 2",
        "1400 px: 'here' from",
        "1400 px without script: the page is 2",
        "1400 px: a figure without a title",
        "1400 px: a figure of ",
        "1400 px: 1 of ",
        "light: 'a pale line': ",
        "print: nav is printed",
        "without script: 'said by a script alone' is hidden",
    ] {
        assert!(complaints.iter().any(|c| c.contains(expected)), "{expected}: {complaints:#?}");
    }
}

const BROKEN: &str = r#"
<p style="white-space:nowrap;width:2000px">a line that does not end <b style="margin-left:1900px">here</b></p>
<p style="color:#bbb;background:#fff">a pale line</p>
<h2 style="display:none">Hidden</h2>
<svg class="lacuna-figure" style="width:10px"></svg>
<p hidden id="late">said by a script alone</p>
<style>@media print { nav { display: block !important } }</style>
<img src="elsewhere.png">
<script>
late.hidden = false;
console.error("said");
throw new Error("thrown");
</script>
"#;

/// All complaints of one page.
fn look_at(tab: &mut Tab, file: &Path) -> Vec<String> {
    let mut look = Look { tab, file, complaints: vec![] };
    look.at_all_widths();
    look.in_light_and_dark();
    look.on_paper();
    look.without_script();
    look.complaints
}

/// Pages of the demo, in a folder that stays for people to look at.
fn pages() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("browser");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let lacuna = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lacuna"));
        let output = command.args(arguments).current_dir(&folder).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    lacuna(&["demo", "--out", "."]);
    let runs = ["recordings/run01.csv", "recordings/run02.csv"];
    let compare = ["compare", "model.toml", "augmented.toml", runs[0], runs[1], "--out", "."];
    lacuna(&compare);
    folder
}

/// One page under the eyes of a reader.
struct Look<'a> {
    tab: &'a mut Tab,
    file: &'a Path,
    complaints: Vec<String>,
}

impl Look<'_> {
    /// Load the page at a width, and complain of errors and of traffic.
    fn load(&mut self, width: u32) {
        let size = json!({"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": false});
        self.tab.call("Emulation.setDeviceMetricsOverride", size);
        self.tab.load(self.file);
        let troubles = self.tab.troubles(self.file);
        self.complain(&format!("{width} px"), troubles);
    }

    fn complain(&mut self, when: &str, found: Vec<String>) {
        let page = self.file.file_name().unwrap().to_string_lossy();
        self.complaints.extend(found.into_iter().map(|c| format!("{page}, {when}: {c}")));
    }

    /// Complaints of a function of look.js.
    fn ask(&mut self, when: &str, function: &str) {
        let found = self.tab.evaluate(&format!("{}.{function}", LOOK.trim_end()));
        let found: Vec<String> = serde_json::from_value(found).unwrap();
        self.complain(when, found);
    }

    fn media(&mut self, media: &str, scheme: &str) {
        let features = json!([{"name": "prefers-color-scheme", "value": scheme}]);
        self.tab.call("Emulation.setEmulatedMedia", json!({"media": media, "features": features}));
    }

    fn at_all_widths(&mut self) {
        for width in WIDTHS {
            self.load(width);
            let when = format!("{width} px");
            for function in ["overflow()", "figures(false)", "readable('[hidden]')"] {
                self.ask(&when, function);
            }
            self.screenshot(width);
        }
    }

    fn in_light_and_dark(&mut self) {
        for scheme in ["light", "dark"] {
            self.media("screen", scheme);
            self.load(WIDTHS[1]);
            self.ask(scheme, "contrast()");
        }
        self.media("", "light");
    }

    fn on_paper(&mut self) {
        self.load(WIDTHS[1]);
        self.media("print", "light");
        self.ask("print", "print()");
        self.ask("print", "figures(true)");
        self.ask("print", "contrast()");
        self.media("", "light");
    }

    fn without_script(&mut self) {
        self.tab.call("Emulation.setScriptExecutionDisabled", json!({"value": true}));
        for width in WIDTHS {
            self.load(width);
            let when = format!("{width} px without script");
            // The hint tells what the script does.
            for function in ["overflow()", "figures(true)", "readable('.hint')"] {
                self.ask(&when, function);
            }
        }
        self.tab.call("Emulation.setScriptExecutionDisabled", json!({"value": false}));
    }

    /// A picture of the whole page beside it.
    fn screenshot(&mut self, width: u32) {
        let whole = json!({"format": "png", "captureBeyondViewport": true});
        let picture = self.tab.call("Page.captureScreenshot", whole);
        let Value::String(text) = &picture["data"] else { panic!("no picture: {picture}") };
        let png = BASE64.decode(text.as_bytes()).unwrap();
        std::fs::write(self.file.with_extension(format!("{width}.png")), png).unwrap();
    }
}
