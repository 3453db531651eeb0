//! The weak form with free initial values.
//!
//! ```text
//! y_k^(p) = sum_(q >= p) a_q t^(q-p) / (q-p)! + int_0^(t_k) (t_k - r)^(s-1-p) / (s-1-p)! [f + g u](gamma(r)) dr + e_k
//! ```
//!
//! for every sample k of a window at once: the paper's test function, with each sample for its end T, and with the
//! initial values a as unknowns instead of estimates. The errors e are those of the samples, independent; the a are
//! reflected out (Householder), which leaves N - s equations. For p = 0 this is, equation for equation, generalised
//! least squares on the divided differences of order s of the samples (int of x^(s) under a B-spline, the compact test
//! function of shortest support), whitened by their exact noise covariance: the difference operator's null space are the
//! polynomials that a spans
//! (`row::tests::reduction_is_whitening_of_divided_differences`).
//!
//! Before anything is identified, the integrand between samples is the kernel's cubic through four neighbouring samples
//! times the input's path ([`WeakWindow::sampled`]); afterwards, the kernel along a trajectory of the identified model
//! ([`WeakWindow::along`], by the Gauss-Legendre rule). Where the motion is too quick for the cubic, the smoothed
//! trajectory disobeys its own weak form; the error that shows there is taken for a random jump of the highest
//! derivative, r_k ~ N(0, q_k^2). What a function may do beyond its landmarks,
//! K - Phi Phi^T along the window, is a random error of the window too ([`WeakRow::remainders`]): without it, whatever
//! else is given freedom follows what the landmarks leave (partially independent training conditional: E. Snelson,
//! Z. Ghahramani, AISTATS 2007).
//!
//! ```text
//! errors of a window ~ N(0, sigma^2 I + sum_k q_k^2 s_k s_k^T + sum_b a_b^2 V_b (K_b - Phi_b Phi_b^T) V_b^T)
//! ```

mod integral;
mod reduction;
mod row;
mod window;

pub(super) use integral::Reflection;
pub(super) use reduction::Reduction;
pub(crate) use row::{Remainders, WeakRow};
pub(super) use window::GAUSS;
pub(crate) use window::{WeakWindow, shares_within};
