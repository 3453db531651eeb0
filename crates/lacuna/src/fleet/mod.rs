//! What `fleet` does: many machines with one model, each diagnosed as by `diagnose`, and then compared.
//!
//! | step | module |
//! | --- | --- |
//! | which machines, which recordings | [`Plan`] |
//! | one machine, its results written whole, and not done twice | [`Work`] |
//! | which of them are done | [`collect`] |
//! | one number of many machines: what is typical, and p-values | [`population`] |
//! | the numbers that are compared | `quantities` |
//! | which machine is unlike the others | [`Unlike`] |
//! | fleet.json, the page | [`Collected`] |
//!
//! Folders of results are all that processes share: a process that is killed loses the machine that it was at,
//! and whoever comes next goes on from what is there.

mod collected;
mod inputs;
mod page;
mod plan;
pub mod population;
mod quantities;
mod unlike;
mod work;

pub use collected::{Collected, Diagnosed, Failed, collect};
pub use inputs::Inputs;
pub use plan::{Machine, Plan};
pub use quantities::{Quantity, Sort, Value};
pub use unlike::{FALSE_RATE, Reason, Unlike};
pub use work::{Settings, State, Work};
