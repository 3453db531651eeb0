//! Rust.

use lacuna_realtime::{LandmarkSum, Profile, Series};

use super::super::Compiled;
use super::header;
use super::numbers::{eights, floats, integers, number};

const BRACKETS: [&str; 2] = ["[", "]"];

pub(super) fn source(compiled: &Compiled) -> String {
    let evaluator = compiled.evaluator();
    let shape = evaluator.shape();
    let (d, n, m) = (shape.arguments, shape.dimension, shape.inputs);
    let mechanism = compiled.acceleration_rows();
    let mut text = String::new();
    for line in header::lines(compiled, &mechanism) {
        text += &format!("// {line}");
        text.truncate(text.trim_end().len());
        text.push('\n');
    }
    text += &format!(
        "
static LOWER: [f64; {d}] = {};
static UPPER: [f64; {d}] = {};
",
        floats(evaluator.lower(), BRACKETS),
        floats(evaluator.upper(), BRACKETS)
    );
    let mut calls = String::new();
    if let Some(series) = evaluator.series() {
        text += &series_tables(series, [d, n + n * m]);
        calls += "    add_series(&nearest, &mut sums);\n";
    }
    for (k, sum) in evaluator.sums().iter().enumerate() {
        text += &landmark_sum(sum, k, [d, n + n * m]);
        calls += &format!("    add_sum_{k}(&nearest, &mut sums);\n");
    }
    if evaluator.sums().iter().any(|sum| !matches!(sum.profile, Profile::Power { .. })) {
        text += EXP;
    }
    let root = |p: &LandmarkSum<'_>| {
        matches!(
            p.profile,
            Profile::MaternHalf | Profile::MaternThreeHalves | Profile::MaternFiveHalves
        )
    };
    if evaluator.sums().iter().any(root) {
        text += SQRT;
    }
    text += &functions([d, n, m], &calls);
    if let Ok(first) = mechanism {
        text += &mass_and_bias([d, n, m], first);
    }
    text
}

fn series_tables(series: &Series<'_>, [d, all]: [usize; 2]) -> String {
    let factors: usize = series.degrees.iter().map(|d| usize::from(*d)).sum::<usize>().max(1);
    let (outer, inner) = (series.outer.parents.len(), series.inner.parents.len());
    let mut text =
        format!("static DEGREES: [u16; {d}] = {};\n", integers(&series.degrees, BRACKETS));
    for (name, products) in [("OUTER", &series.outer), ("INNER", &series.inner)] {
        let count = products.parents.len();
        text += &format!(
            "static {name}_PARENTS: [u16; {count}] = {};\nstatic {name}_FACTORS: [u16; {count}] = {};\n",
            integers(&products.parents, BRACKETS),
            integers(&products.factors, BRACKETS)
        );
    }
    let mut calls = String::new();
    for (k, group) in series.groups.iter().enumerate() {
        let (blocks, entries) = (group.blocks.len(), group.entries.len());
        let flat: Vec<u16> = group.blocks.iter().flatten().copied().collect();
        text += &format!(
            "static ENTRIES_{k}: [u16; {entries}] = {};\n\
             static BLOCKS_{k}: [u16; {}] = {};\n\
             static COEFFICIENTS_{k}: [[f64; 8]; {}] = {};\n",
            integers(&group.entries, BRACKETS),
            2 * blocks,
            integers(&flat, BRACKETS),
            blocks * entries,
            eights(&group.coefficients, BRACKETS)
        );
        calls += &format!(
            "    for b in 0..{blocks} {{
        let (i, j) = (BLOCKS_{k}[2 * b] as usize, 8 * BLOCKS_{k}[2 * b + 1] as usize);
        for e in 0..{entries} {{
            let mut sum = 0.0;
            for (c, p) in COEFFICIENTS_{k}[{entries} * b + e].iter().zip(&inner[j..j + 8]) {{
                sum += c * p;
            }}
            sums[ENTRIES_{k}[e] as usize] += outer[i] * sum;
        }}
    }}
"
        );
    }
    text + &format!(
        "
/// Sum of c_k T_k1(z_1) ... T_kd(z_d), products of polynomials as an outer one times an inner one.
fn add_series(x: &[f64; {d}], sums: &mut [f64; {all}]) {{
    let (mut t, mut outer, mut inner) = ([0.0; {factors}], [1.0; {outer}], [1.0; {inner}]);
    let mut first = 0;
    for i in 0..{d} {{
        let z = (2.0 * x[i] - LOWER[i] - UPPER[i]) / (UPPER[i] - LOWER[i]);
        for k in 0..DEGREES[i] as usize {{
            t[first + k] = match k {{
                0 => z,
                1 => 2.0 * z * z - 1.0,
                _ => 2.0 * z * t[first + k - 1] - t[first + k - 2],
            }};
        }}
        first += DEGREES[i] as usize;
    }}
    for k in 1..{outer} {{
        outer[k] = outer[OUTER_PARENTS[k] as usize] * t[OUTER_FACTORS[k] as usize];
    }}
    for k in 1..{inner} {{
        inner[k] = inner[INNER_PARENTS[k] as usize] * t[INNER_FACTORS[k] as usize];
    }}
{calls}}}
"
    )
}

fn landmark_sum(sum: &LandmarkSum<'_>, k: usize, [d, all]: [usize; 2]) -> String {
    let entries = sum.entries.len();
    let rows = d + entries;
    let tiles = sum.tiles.len() / rows;
    let term = if sum.profile.is_radial() {
        "(y[j] - tile[j][i]) * (y[j] - tile[j][i])"
    } else {
        "y[j] * tile[j][i]"
    };
    let profile = match sum.profile {
        Profile::Exponential => "let v = exp(s);".to_owned(),
        Profile::Gaussian => "let v = exp(-0.5 * s);".to_owned(),
        Profile::Power { offset, degree } => format!(
            "let mut v = 1.0;
            for _ in 0..{degree} {{
                v *= s + {};
            }}",
            number(offset)
        ),
        Profile::MaternHalf => "let v = exp(-sqrt(s));".to_owned(),
        Profile::MaternThreeHalves => {
            "let r = sqrt(3.0 * s);\n            let v = (1.0 + r) * exp(-r);".to_owned()
        }
        Profile::MaternFiveHalves => {
            "let r = sqrt(5.0 * s);\n            let v = (1.0 + r + r * r / 3.0) * exp(-r);"
                .to_owned()
        }
    };
    format!(
        "
static SUM_ENTRIES_{k}: [u16; {entries}] = {};
static CENTRE_{k}: [f64; {d}] = {};
static SCALE_{k}: [f64; {d}] = {};
static TILES_{k}: [[f64; 8]; {}] = {};

/// Sum of w_p psi(s_p), eight landmarks a tile: their coordinates, then their weights.
fn add_sum_{k}(x: &[f64; {d}], sums: &mut [f64; {all}]) {{
    let mut y = [0.0; {d}];
    for j in 0..{d} {{
        y[j] = (x[j] - CENTRE_{k}[j]) * SCALE_{k}[j];
    }}
    for b in 0..{tiles} {{
        let tile = &TILES_{k}[{rows} * b..{rows} * (b + 1)];
        for i in 0..8 {{
            let mut s = 0.0;
            for j in 0..{d} {{
                s += {term};
            }}
            {profile}
            for e in 0..{entries} {{
                sums[SUM_ENTRIES_{k}[e] as usize] += v * tile[{d} + e][i];
            }}
        }}
    }}
}}
",
        integers(&sum.entries, BRACKETS),
        floats(&sum.centre, BRACKETS),
        floats(&sum.factors, BRACKETS),
        rows * tiles,
        eights(&sum.tiles, BRACKETS),
    )
}

/// There is none without std.
const EXP: &str = "
/// e^x within 2 units in the last place: x = n ln 2 + r, and the Taylor polynomial in r.
fn exp(x: f64) -> f64 {
    let x = if x < -708.0 { -708.0 } else if x > 709.0 { 709.0 } else { x };
    let shifted = x * core::f64::consts::LOG2_E + 6_755_399_441_055_744.0;
    let n = shifted - 6_755_399_441_055_744.0;
    let r = (x - n * 0.693_147_180_369_123_8) - n * 1.908_214_929_270_587_7e-10;
    let mut sum = 1.0;
    for k in (1..14).rev() {
        sum = 1.0 + sum * r / k as f64;
    }
    f64::from_bits(sum.to_bits().wrapping_add(shifted.to_bits() << 52))
}
";

const SQRT: &str = "
/// Newton's iteration from half the exponent.
fn sqrt(x: f64) -> f64 {
    if !(x > 0.0) {
        return x;
    }
    let mut root = f64::from_bits((x.to_bits() >> 1) + 0x1ff8_0000_0000_0000);
    for _ in 0..5 {
        root = 0.5 * (root + x / root);
    }
    root
}
";

fn functions([d, n, m]: [usize; 3], calls: &str) -> String {
    let (all, size) = (n + n * m, n * m);
    format!(
        "
/// Whether x is in the box.
pub fn inside(x: &[f64; {d}]) -> bool {{
    (0..{d}).all(|i| LOWER[i] <= x[i] && x[i] <= UPPER[i])
}}

/// Writes f(x) and g(x) (row-major). False where x is outside the box: they are those of its nearest point.
pub fn evaluate(x: &[f64; {d}], f: &mut [f64; {n}], g: &mut [f64; {size}]) -> bool {{
    let mut nearest = *x;
    for i in 0..{d} {{
        if x[i] < LOWER[i] {{
            nearest[i] = LOWER[i];
        }} else if x[i] > UPPER[i] {{
            nearest[i] = UPPER[i];
        }}
    }}
    let mut sums = [0.0; {all}];
{calls}    f.copy_from_slice(&sums[..{n}]);
    g.copy_from_slice(&sums[{n}..]);
    inside(x)
}}
"
    )
}

fn mass_and_bias([d, n, m]: [usize; 3], first: usize) -> String {
    let (all, square, width) = (n * m, m * m, 2 * m);
    format!(
        "
/// M (row-major) and c of u = M q'' + c; the flag is false where x is outside the box. None where g is singular.
pub fn mass_and_bias(x: &[f64; {d}]) -> Option<([f64; {square}], [f64; {m}], bool)> {{
    let (mut f, mut g) = ([0.0; {n}], [0.0; {all}]);
    let inside = evaluate(x, &mut f, &mut g);
    let mut a = [[0.0; {width}]; {m}];
    let mut largest: f64 = 0.0;
    for i in 0..{m} {{
        for j in 0..{m} {{
            a[i][j] = g[({first} + i) * {m} + j];
            largest = largest.max(a[i][j]).max(-a[i][j]);
        }}
        a[i][{m} + i] = 1.0;
    }}
    // Gauss and Jordan, by the largest pivot of each column.
    for k in 0..{m} {{
        let mut pivot = k;
        for i in k..{m} {{
            if a[i][k] * a[i][k] > a[pivot][k] * a[pivot][k] {{
                pivot = i;
            }}
        }}
        if !(a[pivot][k] > 1e-12 * largest || -a[pivot][k] > 1e-12 * largest) {{
            return None;
        }}
        a.swap(pivot, k);
        let inverse = 1.0 / a[k][k];
        for j in 0..{width} {{
            a[k][j] *= inverse;
        }}
        for i in 0..{m} {{
            let factor = a[i][k];
            for j in 0..{width} {{
                if i != k {{
                    a[i][j] -= factor * a[k][j];
                }}
            }}
        }}
    }}
    let (mut mass, mut bias) = ([0.0; {square}], [0.0; {m}]);
    for i in 0..{m} {{
        for j in 0..{m} {{
            mass[i * {m} + j] = a[i][{m} + j];
            bias[i] -= a[i][{m} + j] * f[{first} + j];
        }}
    }}
    Some((mass, bias, inside))
}}
"
    )
}
