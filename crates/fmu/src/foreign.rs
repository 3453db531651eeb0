//! The functions of an FMU's shared library: all that is unsafe.
//!
//! What a function of C does cannot be checked. What can: it has the type that the standard gives its
//! name (`fmi2Functions.h`, `fmi3Functions.h`); pointers are to slices whose lengths are handed over with
//! them and that outlive the call; an instance is used by one thread ([`Instance`] is not `Send`), and not
//! after it was freed, nor once the library is unloaded, which it keeps loaded. What a broken library does
//! to memory ends with the process that it is called in ([`crate::serve`]).
#![allow(unsafe_code)]

use crate::{Description, Version};
use libloading::Library;
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::Path;
use std::ptr::{null, null_mut};
use std::rc::Rc;

type Raw = *mut c_void;
type Status = c_int;
type Act = unsafe extern "C" fn(Raw) -> Status;
type SetTime = unsafe extern "C" fn(Raw, f64) -> Status;
type SetStates = unsafe extern "C" fn(Raw, *const f64, usize) -> Status;
type GetDerivatives = unsafe extern "C" fn(Raw, *mut f64, usize) -> Status;

/// Statuses of both versions.
const WARNING: Status = 1;
const FATAL: Status = 4;

/// Why a call did not do what it is for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Failure {
    pub what: String,
    /// Whether nothing of the library may be called any more.
    pub fatal: bool,
}

impl Failure {
    pub(crate) fn new(what: impl Into<String>) -> Self {
        Self { what: what.into(), fatal: false }
    }
}

thread_local! {
    /// What the library said last that was not merely informative.
    static SAID: RefCell<String> = const { RefCell::new(String::new()) };
}

/// What `fmi2EventInfo` is.
#[repr(C)]
#[derive(Default)]
struct EventInfo {
    new_discrete_states_needed: c_int,
    terminate_simulation: c_int,
    nominals_changed: c_int,
    values_changed: c_int,
    next_event_time_defined: c_int,
    next_event_time: f64,
}

/// What `fmi2CallbackFunctions` is.
#[repr(C)]
struct Callbacks {
    logger: unsafe extern "C" fn(Raw, *const c_char, Status, *const c_char, *const c_char),
    allocate: unsafe extern "C" fn(usize, usize) -> Raw,
    free: unsafe extern "C" fn(Raw),
    step_finished: *const c_void,
    environment: Raw,
}

unsafe extern "C" {
    fn calloc(count: usize, size: usize) -> Raw;
    fn free(memory: Raw);
}

/// The logger of FMI 2. It is called with more arguments (as `printf` is), which it does not look at:
/// the calling conventions of the platforms in [`crate::platform`] let a function leave those alone.
/// The text is therefore that of the format, without its values.
unsafe extern "C" fn log_two(
    _: Raw,
    _: *const c_char,
    status: Status,
    _: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the standard has a string there, or nothing.
    unsafe { remember(status, message) }
}

/// The logger of FMI 3.
unsafe extern "C" fn log_three(_: Raw, status: Status, _: *const c_char, message: *const c_char) {
    // SAFETY: as above.
    unsafe { remember(status, message) }
}

/// # Safety
/// `message` is null or a string that ends.
unsafe fn remember(status: Status, message: *const c_char) {
    if status > 0 && !message.is_null() {
        // SAFETY: by what the caller says.
        let text = unsafe { CStr::from_ptr(message) }.to_string_lossy().trim().to_owned();
        SAID.with_borrow_mut(|said| *said = text);
    }
}

/// A status as a result; `call` is the function's name.
fn done(status: Status, call: &str) -> Result<(), Failure> {
    if (0..=WARNING).contains(&status) {
        return Ok(());
    }
    let kind = match status {
        2 => "discarded the call",
        3 => "failed",
        _ => "failed for good",
    };
    let said = SAID.with_borrow_mut(std::mem::take);
    let because = if said.is_empty() { said } else { format!(": {said}") };
    Err(Failure { what: format!("{call} {kind}{because}"), fatal: status >= FATAL })
}

/// Functions that are alike in both versions, and those that are not.
struct Functions {
    free: unsafe extern "C" fn(Raw),
    exit_initialization: Act,
    enter_continuous: Act,
    set_time: SetTime,
    set_states: SetStates,
    get_derivatives: GetDerivatives,
    unlike: Unlike,
    _library: Library,
}

type Instantiate2 = unsafe extern "C" fn(
    *const c_char,
    c_int,
    *const c_char,
    *const c_char,
    *const Callbacks,
    c_int,
    c_int,
) -> Raw;
type Instantiate3 = unsafe extern "C" fn(
    *const c_char,
    *const c_char,
    *const c_char,
    bool,
    bool,
    Raw,
    unsafe extern "C" fn(Raw, Status, *const c_char, *const c_char),
) -> Raw;
type Set2 = unsafe extern "C" fn(Raw, *const u32, usize, *const f64) -> Status;
type Get2 = unsafe extern "C" fn(Raw, *const u32, usize, *mut f64) -> Status;
type Set3 = unsafe extern "C" fn(Raw, *const u32, usize, *const f64, usize) -> Status;
type Get3 = unsafe extern "C" fn(Raw, *const u32, usize, *mut f64, usize) -> Status;
type Directional2 =
    unsafe extern "C" fn(Raw, *const u32, usize, *const u32, usize, *const f64, *mut f64) -> Status;
type Directional3 = unsafe extern "C" fn(
    Raw,
    *const u32,
    usize,
    *const u32,
    usize,
    *const f64,
    usize,
    *mut f64,
    usize,
) -> Status;

enum Unlike {
    Two {
        instantiate: Instantiate2,
        setup: unsafe extern "C" fn(Raw, c_int, f64, f64, c_int, f64) -> Status,
        enter_initialization: Act,
        new_discrete_states: unsafe extern "C" fn(Raw, *mut EventInfo) -> Status,
        set: Set2,
        get: Get2,
        directional: Option<Directional2>,
    },
    Three {
        instantiate: Instantiate3,
        enter_initialization: unsafe extern "C" fn(Raw, bool, f64, f64, bool, f64) -> Status,
        update_discrete_states: unsafe extern "C" fn(
            Raw,
            *mut bool,
            *mut bool,
            *mut bool,
            *mut bool,
            *mut bool,
            *mut f64,
        ) -> Status,
        set: Set3,
        get: Get3,
        directional: Option<Directional3>,
    },
}

/// A function by its name.
///
/// # Safety
/// `T` is the type that the standard gives it.
unsafe fn function<T: Copy>(library: &Library, name: &str) -> Result<T, Failure> {
    // SAFETY: by what the caller says.
    match unsafe { library.get::<T>(name.as_bytes()) } {
        Ok(symbol) => Ok(*symbol),
        Err(_) => Err(Failure::new(format!("its library has no function {name}"))),
    }
}

impl Functions {
    fn load(file: &Path, d: &Description) -> Result<Self, Failure> {
        // SAFETY: what the library does when it is loaded is as unknown as what its functions do.
        let library = unsafe { Library::new(file) }
            .map_err(|e| Failure::new(format!("its library cannot be loaded: {e}")))?;
        // SAFETY: types are those of the standard's headers.
        unsafe {
            let (prefix, derivatives, unlike) = match d.version {
                Version::Two => ("fmi2", "fmi2GetDerivatives", Self::two(&library, d)?),
                Version::Three => {
                    ("fmi3", "fmi3GetContinuousStateDerivatives", Self::three(&library, d)?)
                }
            };
            let named = |name: &str| format!("{prefix}{name}");
            Ok(Self {
                free: function(&library, &named("FreeInstance"))?,
                exit_initialization: function(&library, &named("ExitInitializationMode"))?,
                enter_continuous: function(&library, &named("EnterContinuousTimeMode"))?,
                set_time: function(&library, &named("SetTime"))?,
                set_states: function(&library, &named("SetContinuousStates"))?,
                get_derivatives: function(&library, derivatives)?,
                unlike,
                _library: library,
            })
        }
    }

    /// # Safety
    /// As of [`function`].
    unsafe fn two(library: &Library, d: &Description) -> Result<Unlike, Failure> {
        // SAFETY: types are those of fmi2Functions.h.
        unsafe {
            Ok(Unlike::Two {
                instantiate: function(library, "fmi2Instantiate")?,
                setup: function(library, "fmi2SetupExperiment")?,
                enter_initialization: function(library, "fmi2EnterInitializationMode")?,
                new_discrete_states: function(library, "fmi2NewDiscreteStates")?,
                set: function(library, "fmi2SetReal")?,
                get: function(library, "fmi2GetReal")?,
                directional: match d.has_derivatives {
                    true => Some(function(library, "fmi2GetDirectionalDerivative")?),
                    false => None,
                },
            })
        }
    }

    /// # Safety
    /// As of [`function`].
    unsafe fn three(library: &Library, d: &Description) -> Result<Unlike, Failure> {
        // SAFETY: types are those of fmi3Functions.h.
        unsafe {
            Ok(Unlike::Three {
                instantiate: function(library, "fmi3InstantiateModelExchange")?,
                enter_initialization: function(library, "fmi3EnterInitializationMode")?,
                update_discrete_states: function(library, "fmi3UpdateDiscreteStates")?,
                set: function(library, "fmi3SetFloat64")?,
                get: function(library, "fmi3GetFloat64")?,
                directional: match d.has_derivatives {
                    true => Some(function(library, "fmi3GetDirectionalDerivative")?),
                    false => None,
                },
            })
        }
    }
}

/// A loaded library with what its instances are told.
pub(crate) struct Unit {
    functions: Functions,
    name: CString,
    token: CString,
    /// A URI in FMI 2, a path in FMI 3.
    resources: CString,
    callbacks: Callbacks,
}

impl Unit {
    /// Load the library of an FMU that is unpacked.
    pub(crate) fn load(
        library: &Path,
        resources: &Path,
        d: &Description,
    ) -> Result<Rc<Self>, Failure> {
        let text = |text: String| {
            CString::new(text).map_err(|_| Failure::new("a name in its description holds a 0 byte"))
        };
        let resources = resources.display();
        let resources = match d.version {
            Version::Two => format!("file://{resources}"),
            Version::Three => format!("{resources}/"),
        };
        Ok(Rc::new(Self {
            functions: Functions::load(library, d)?,
            name: text(d.name.clone())?,
            token: text(d.token.clone())?,
            resources: text(resources)?,
            callbacks: Callbacks {
                logger: log_two,
                allocate: calloc,
                free,
                step_finished: null(),
                environment: null_mut(),
            },
        }))
    }
}

/// An instance, freed when it is dropped.
pub(crate) struct Instance {
    unit: Rc<Unit>,
    raw: Raw,
    fatal: bool,
}

impl Drop for Instance {
    fn drop(&mut self) {
        if !self.fatal {
            // SAFETY: it was instantiated, and is not used after this.
            unsafe { (self.unit.functions.free)(self.raw) }
        }
    }
}

impl Instance {
    /// A new instance, before its initialization.
    pub(crate) fn new(unit: &Rc<Unit>) -> Result<Self, Failure> {
        let (name, token, resources) =
            (unit.name.as_ptr(), unit.token.as_ptr(), unit.resources.as_ptr());
        // SAFETY: all that is pointed to lives as long as the unit, which the instance holds.
        let raw = unsafe {
            match &unit.functions.unlike {
                Unlike::Two { instantiate, .. } => {
                    instantiate(name, 0, token, resources, &raw const unit.callbacks, 0, 0)
                }
                Unlike::Three { instantiate, .. } => {
                    instantiate(name, token, resources, false, false, null_mut(), log_three)
                }
            }
        };
        if raw.is_null() {
            let said = SAID.with_borrow_mut(std::mem::take);
            let because = if said.is_empty() { said } else { format!(": {said}") };
            return Err(Failure::new(format!("it cannot be instantiated{because}")));
        }
        Ok(Self { unit: unit.clone(), raw, fatal: false })
    }

    fn done(&mut self, status: Status, call: &str) -> Result<(), Failure> {
        let result = done(status, call);
        self.fatal |= result.as_ref().is_err_and(|failure| failure.fatal);
        result
    }

    /// From instantiated to where derivatives can be asked for, at time 0.
    pub(crate) fn initialize(&mut self) -> Result<(), Failure> {
        let unit = self.unit.clone();
        // SAFETY: an instance that was just made.
        let status = unsafe {
            match &unit.functions.unlike {
                Unlike::Two { setup, enter_initialization, .. } => {
                    let status = setup(self.raw, 0, 0.0, 0.0, 0, 0.0);
                    self.done(status, "fmi2SetupExperiment")?;
                    enter_initialization(self.raw)
                }
                Unlike::Three { enter_initialization, .. } => {
                    enter_initialization(self.raw, false, 0.0, 0.0, false, 0.0)
                }
            }
        };
        self.done(status, "entering the initialization")?;
        // SAFETY: it is in initialization mode.
        let status = unsafe { (unit.functions.exit_initialization)(self.raw) };
        self.done(status, "the initialization")?;
        self.settle()?;
        // SAFETY: it is in event mode.
        let status = unsafe { (unit.functions.enter_continuous)(self.raw) };
        self.done(status, "entering continuous time")
    }

    /// The event that every simulation begins with.
    fn settle(&mut self) -> Result<(), Failure> {
        /// More than any settles in.
        const ROUNDS: usize = 100;
        let unit = self.unit.clone();
        for _ in 0..ROUNDS {
            let mut info = EventInfo::default();
            // SAFETY: it is in event mode; what is pointed to is written before the call returns.
            let status = unsafe {
                match &unit.functions.unlike {
                    Unlike::Two { new_discrete_states, .. } => {
                        new_discrete_states(self.raw, &raw mut info)
                    }
                    Unlike::Three { update_discrete_states, .. } => {
                        let mut flags = [false; 5];
                        let [needed, terminate, nominals, values, timed] = &mut flags;
                        let time = &raw mut info.next_event_time;
                        let status = update_discrete_states(
                            self.raw, needed, terminate, nominals, values, timed, time,
                        );
                        info.new_discrete_states_needed = flags[0].into();
                        info.terminate_simulation = flags[1].into();
                        info.next_event_time_defined = flags[4].into();
                        status
                    }
                }
            };
            self.done(status, "the event at the beginning")?;
            if info.terminate_simulation != 0 {
                return Err(Failure::new("it ends the simulation where it begins"));
            }
            if info.next_event_time_defined != 0 {
                return Err(Failure::new(format!(
                    "it has an event at {} s (a time event), where it changes: not supported",
                    info.next_event_time
                )));
            }
            if info.new_discrete_states_needed == 0 {
                return Ok(());
            }
        }
        Err(Failure::new("its event at the beginning does not settle"))
    }

    /// Set variables.
    pub(crate) fn set(&mut self, references: &[u32], values: &[f64]) -> Result<(), Failure> {
        let count = references.len();
        assert_eq!(count, values.len());
        if count == 0 {
            return Ok(());
        }
        let (r, v) = (references.as_ptr(), values.as_ptr());
        // SAFETY: both are of the length that is told.
        let status = unsafe {
            match &self.unit.functions.unlike {
                Unlike::Two { set, .. } => set(self.raw, r, count, v),
                Unlike::Three { set, .. } => set(self.raw, r, count, v, count),
            }
        };
        self.done(status, "setting values")
    }

    /// Get variables.
    pub(crate) fn get(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Failure> {
        let count = references.len();
        assert_eq!(count, values.len());
        if count == 0 {
            return Ok(());
        }
        let (r, v) = (references.as_ptr(), values.as_mut_ptr());
        // SAFETY: both are of the length that is told.
        let status = unsafe {
            match &self.unit.functions.unlike {
                Unlike::Two { get, .. } => get(self.raw, r, count, v),
                Unlike::Three { get, .. } => get(self.raw, r, count, v, count),
            }
        };
        self.done(status, "getting values")
    }

    /// Go to a time and to continuous states, of which there are as many as derivatives.
    pub(crate) fn go(&mut self, time: f64, states: &[f64]) -> Result<(), Failure> {
        // SAFETY: it is in continuous time; the length is told.
        let status = unsafe { (self.unit.functions.set_time)(self.raw, time) };
        self.done(status, "setting the time")?;
        let set = self.unit.functions.set_states;
        // SAFETY: as above.
        let status = unsafe { set(self.raw, states.as_ptr(), states.len()) };
        self.done(status, "setting the states")
    }

    /// Derivatives of the states by time.
    pub(crate) fn derivatives(&mut self, to: &mut [f64]) -> Result<(), Failure> {
        let get = self.unit.functions.get_derivatives;
        // SAFETY: it is in continuous time; the length is told.
        let status = unsafe { get(self.raw, to.as_mut_ptr(), to.len()) };
        self.done(status, "getting the derivatives")
    }

    /// Derivatives of variables by one variable.
    pub(crate) fn along(&mut self, of: &[u32], by: u32, to: &mut [f64]) -> Result<(), Failure> {
        let count = of.len();
        assert_eq!(count, to.len());
        let (one, seed) = ([by], [1.0]);
        let (o, b, s, t) = (of.as_ptr(), one.as_ptr(), seed.as_ptr(), to.as_mut_ptr());
        // SAFETY: it is in continuous time; all are of the lengths that are told.
        let status = unsafe {
            match &self.unit.functions.unlike {
                Unlike::Two { directional: Some(get), .. } => get(self.raw, o, count, b, 1, s, t),
                Unlike::Three { directional: Some(get), .. } => {
                    get(self.raw, o, count, b, 1, s, 1, t, count)
                }
                _ => return Err(Failure::new("it has no derivatives of its own")),
            }
        };
        self.done(status, "getting directional derivatives")
    }
}
