//! Proof: recordings that nothing was fitted to.

use super::table::table;
use crate::Proof;
use crate::number::{change, plain, ratio};
use crate::pictures::{Series, shown};
use crate::words;
use lacuna_discrepancy::Diagnosis;
use lacuna_discrepancy::diagnosis::ChannelFit;
use maud::{Markup, html};

pub(crate) fn section(d: &Diagnosis, series: &[Proof]) -> Markup {
    let shown = shown(d, series);
    let first = words::telling(d).map(|(channel, _)| channel);
    super::section(
        "proof",
        "The model before and after, on recordings that nothing was fitted to. In the pictures it \
         runs free: it is told the first samples and the inputs, and nothing of what was measured \
         after them.",
        html! {
            (errors(d))
            (by_recording(d))
            p.about.hint hidden {
                "Point at a picture for its values, or focus it and use the arrow keys. Over time, drag \
                 to look closer; a double click or Escape resets."
            }
            div.proofs data-first=[first] { @for s in &shown.drawn { (one(s)) } }
            @if shown.left > 0 { p.about { (shown.left) " more series are not drawn." } }
        },
    )
}

/// A recording's channel: the run, the residuals, their autocorrelation.
fn one(s: &Series) -> Markup {
    let Proof { recording, channel, .. } = s.proof;
    html! {
        article.series data-recording=(recording) data-channel=(channel) {
            h3 { (channel) " in " (recording) }
            div.figures.three { @for p in &s.pictures { (super::figure(p)) } }
        }
    }
}

fn errors(d: &Diagnosis) -> Markup {
    let rows: Vec<_> = words::by_error(d).into_iter().map(row).collect();
    let head = ["Channel", "Noise", "Windows", "Times the noise", "Running free", ""];
    let horizon = d.fit.held_out.values().next().map_or(String::new(), |f| plain(f.horizon_s, "s"));
    let caption = format!("Rms error on held-out recordings, before → after; windows of {horizon}");
    html! {
        @if rows.is_empty() { p { "No recording was held out." } }
        @else { (table(&caption, &head, &rows)) }
    }
}

/// Channels that are shown of each recording; `diagnosis.json` has all.
const SHOWN: usize = 4;

/// The same windows, recording by recording, of the channels where the model was worst.
fn by_recording(d: &Diagnosis) -> Markup {
    let channels: Vec<&str> = words::by_error(d).into_iter().map(|c| c.0).take(SHOWN).collect();
    let head: Vec<&str> = std::iter::once("Recording").chain(channels.iter().copied()).collect();
    let rows: Vec<Vec<String>> = d
        .fit
        .by_recording
        .iter()
        .map(|(recording, fits)| {
            let cell = |channel: &&str| match fits.get(*channel) {
                Some(f) => change(f.rmse_before, "→", f.rmse_after, &f.unit),
                None => "-".to_owned(),
            };
            std::iter::once(recording.clone()).chain(channels.iter().map(cell)).collect()
        })
        .collect();
    let caption = "Rms error over windows, by recording, before → after";
    html! { @if !rows.is_empty() { (table(caption, &head, &rows)) } }
}

fn row((name, f): (&str, &ChannelFit)) -> Vec<String> {
    let arrow = |before, after| change(before, "→", after, &f.unit);
    let times = |v: f64| ratio(v / f.noise);
    let noisy = match f.noise > 0.0 {
        true => format!("{} → {}", times(f.rmse_before), times(f.rmse_after)),
        false => "-".to_owned(),
    };
    let remark = match (
        words::grows(f.rmse_before, f.rmse_after)
            || words::grows(f.free_run_before, f.free_run_after),
        words::falls(f.rmse_before, f.rmse_after),
    ) {
        (true, _) => "worse",
        (false, true) => "better",
        (false, false) => "same",
    };
    vec![
        name.to_owned(),
        plain(f.noise, &f.unit),
        arrow(f.rmse_before, f.rmse_after),
        noisy,
        arrow(f.free_run_before, f.free_run_after),
        remark.to_owned(),
    ]
}
