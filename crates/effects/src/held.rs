//! Series that are held from each sample to the next.

use lacuna_numbers::Number;

/// Series value `delay` seconds earlier, averaged over each step, for a held series. Before the
/// series its first value was held.
///
/// With the running integral I of the held series u, the value of the step from a to b is
/// `(I(b - delay) - I(a - delay)) / (b - a)`; its derivative by the delay is the difference
/// `(u(a - delay) - u(b - delay)) / (b - a)` of the held values at both ends, those before a
/// sample rather than after it: a longer delay looks further back.
pub(crate) fn delayed<T: Number>(times: &[f64], held: &[T], delay: T) -> Vec<T> {
    let integral = running_integral(times, held);
    let at = |t: T| {
        let k = times.partition_point(|&s| s < t.value()).saturating_sub(1);
        integral[k] + held[k] * (t - times[k])
    };
    let last = times.len().saturating_sub(1);
    (0..times.len())
        .map(|k| {
            let (a, b) = match k {
                _ if last == 0 => return held[0],
                _ if k == last => (times[k], 2.0 * times[k] - times[k - 1]),
                _ => (times[k], times[k + 1]),
            };
            // The difference below would be lost in the digits of a long delay.
            if b - delay.value() <= times[0] {
                return held[0];
            }
            (at(-delay + b) - at(-delay + a)) / (b - a)
        })
        .collect()
}

/// `int_{t_0}^{t_k} held dt` of a held series.
fn running_integral<T: Number>(times: &[f64], held: &[T]) -> Vec<T> {
    let mut sum = T::constant(0.0);
    let mut out = vec![sum];
    for (pair, value) in times.windows(2).zip(held) {
        sum = sum + *value * (pair[1] - pair[0]);
        out.push(sum);
    }
    out
}
