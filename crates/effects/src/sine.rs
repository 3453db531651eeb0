//! Sines as sums that are linear in their amplitudes:
//! `A sin(x + p) = A cos(p) sin(x) + A sin(p) cos(x)`.

/// Amplitudes of sine and cosine, and the rate, of amplitude, rate and phase.
pub(crate) fn sine_internal(physical: &[f64]) -> Vec<f64> {
    let [amplitude, rate, phase] = physical else { unreachable!("three parameters") };
    vec![amplitude * phase.cos(), amplitude * phase.sin(), *rate]
}

/// The inverse of [`sine_internal`].
pub(crate) fn sine_physical(internal: &[f64]) -> Vec<f64> {
    let [sine, cosine, rate] = internal else { unreachable!("three parameters") };
    vec![sine.hypot(*cosine), *rate, cosine.atan2(*sine)]
}
