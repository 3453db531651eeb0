//! The table.

/// One line: what, and the time of one of it here and by the peer.
pub struct Row {
    what: String,
    seconds: f64,
    peer: Option<f64>,
    /// Whether to print how many a second.
    rate: bool,
}

impl Row {
    /// A time.
    pub fn seconds(what: &str, seconds: f64, peer: Option<f64>) -> Self {
        Self { what: what.to_owned(), seconds, peer, rate: false }
    }

    /// So many a second, from the time of one.
    pub fn rate(what: &str, seconds: f64, peer: Option<f64>) -> Self {
        Self { rate: true, ..Self::seconds(what, seconds, peer) }
    }

    fn value(&self, seconds: f64) -> String {
        match seconds {
            s if self.rate => format!("{:.2} G/s", 1e-9 / s),
            s if s < 1e-3 => format!("{:.2} us", 1e6 * s),
            s if s < 1.0 => format!("{:.2} ms", 1e3 * s),
            s => format!("{s:.2} s"),
        }
    }
}

/// Prints all, with ratios.
pub fn print(rows: &[Row]) {
    println!("{:>10} {:>10} {:>7}  work", "Lacuna", "NumPy", "ratio");
    for row in rows {
        let own = row.value(row.seconds);
        let (peer, ratio) = match row.peer {
            Some(peer) => (row.value(peer), format!("{:.1}", peer / row.seconds)),
            None => ("-".to_owned(), "-".to_owned()),
        };
        println!("{own:>10} {peer:>10} {ratio:>7}  {}", row.what);
    }
}
