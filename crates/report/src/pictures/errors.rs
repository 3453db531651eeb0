//! Held-out errors before and after against the noise.

use super::{Drawing, Picture};
use crate::number::{diverged, plain, ratio};
use crate::words;
use lacuna_charts::{Ratio, Ratios};
use lacuna_discrepancy::Diagnosis;
use lacuna_discrepancy::diagnosis::ChannelFit;

/// Channels that are drawn, the worst first; the table has all.
const CHANNELS: usize = 6;

/// The errors over windows of each channel whose noise is known; none where nothing was held out.
pub(crate) fn errors(d: &Diagnosis) -> Option<Picture> {
    let mut fits = words::by_error(d);
    fits.retain(|(_, f)| f.noise > 0.0);
    fits.truncate(CHANNELS);
    let horizon = plain(fits.first()?.1.horizon_s, "s");
    let rows: Vec<Ratio> = fits.into_iter().map(row).collect();
    let one =
        |r: &Ratio| format!("{} {} before, {} after", r.label, ratio(r.before), ratio(r.after));
    let all: Vec<String> = rows.iter().map(one).collect();
    let description = format!(
        "Rms errors on held-out recordings over windows of {horizon}, in units of the noise: {}.",
        all.join("; ")
    );
    Some(Picture {
        kind: "errors",
        of: d.model.clone(),
        caption: format!("Error on held-out recordings over {horizon}, against the noise"),
        drawing: Drawing::Ratios(Ratios { description, rows }),
    })
}

fn row((name, fit): (&str, &ChannelFit)) -> Ratio {
    let over = |v: f64| if diverged(v) { f64::INFINITY } else { v / fit.noise };
    let (before, after) = (over(fit.rmse_before), over(fit.rmse_after));
    let says = format!("{} → {}", times(before), times(after));
    Ratio { label: name.to_owned(), before, after, says }
}

fn times(v: f64) -> String {
    if v.is_finite() { format!("{}×", ratio(v)) } else { "diverges".to_owned() }
}
