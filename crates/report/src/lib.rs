//! Pictures, pages and words of a diagnosis.
//!
//! A report shows, channel by channel, the force that the model leaves out,
//!
//! ```text
//! M(q) q'' = F(q, q', u) + r,      r = (named law) + (remainder),
//! ```
//!
//! as it was learned from the recordings and as the named law says it, and the error on
//! held-out recordings before and after that law is added. It reads results only.
//!
//! | on paper | in code |
//! | --- | --- |
//! | missing force r as learned, its standard deviation | `learned`, `std` of a [`Curve`] |
//! | the named law | `law` of a [`Curve`] |
//! | measured channel, model before and after | `measured`, `before`, `after` of a [`Proof`] |
//! | estimate and its standard deviation | [`number::with_std`] |
//!
//! [`Curve`]: lacuna_discrepancy::diagnosis::Curve

mod autocorrelation;
mod joints;
mod page;
mod pictures;
mod proof;
mod summary;
mod thin;
mod words;

pub use lacuna_discrepancy::number;

pub use page::{
    Closer, ComparedChannel, ComparedSeries, Comparison, DifferencePage, FleetPage, FleetRow,
    FleetTable, compare_page, difference_page, fleet_page, page,
};
pub use pictures::{FigureFile, files};
pub use proof::{Imposed, Proof};
pub use summary::summary;
pub use words::class_at;
