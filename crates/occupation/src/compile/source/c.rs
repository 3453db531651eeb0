//! C99.

use std::fmt::Write;

use lacuna_realtime::{LandmarkSum, Profile, Series};

use super::super::Compiled;
use super::header;
use super::numbers::{eights, floats, integers, number};

const BRACES: [&str; 2] = ["{", "}"];

pub(super) fn source(compiled: &Compiled, prefix: &str) -> String {
    let evaluator = compiled.evaluator();
    let shape = evaluator.shape();
    let (d, n, m) = (shape.arguments, shape.dimension, shape.inputs);
    let mechanism = compiled.acceleration_rows();
    let mut text = String::from("/*\n");
    for line in header::lines(compiled, &mechanism) {
        // A name must not end the comment.
        text += &format!(" * {}", line.replace("*/", "* /"));
        text.truncate(text.trim_end().len());
        text.push('\n');
    }
    text += &format!(" *\n{} */\n", declarations(prefix, [d, n, m], &mechanism));
    if evaluator.sums().iter().any(|sum| !matches!(sum.profile, Profile::Power { .. })) {
        text += "#include <math.h>\n";
    }
    text += &format!(
        "\nstatic const double lower[{d}] = {};\nstatic const double upper[{d}] = {};\n",
        floats(evaluator.lower(), BRACES),
        floats(evaluator.upper(), BRACES)
    );
    let mut calls = String::new();
    if let Some(series) = evaluator.series() {
        text += &series_tables(series, d);
        calls += "    add_series(nearest, sums);\n";
    }
    for (k, sum) in evaluator.sums().iter().enumerate() {
        text += &landmark_sum(sum, k, d);
        writeln!(calls, "    add_sum_{k}(nearest, sums);").expect("text takes text");
    }
    text += &functions(prefix, [d, n, m], &calls);
    if let Ok(first) = mechanism {
        text += &mass_and_bias(prefix, [d, n, m], first);
    }
    text
}

fn declarations(prefix: &str, [d, n, m]: [usize; 3], mechanism: &Result<usize, String>) -> String {
    let size = (n * m).max(1);
    let mut text = format!(
        " * int {prefix}_inside(const double x[{d}]);\n *     1 in the box, 0 outside\n\
         * int {prefix}_evaluate(const double x[{d}], double f[{n}], double g[{size}]);\n \
         *     0, or 1 where x is outside the box\n",
    )
    .replace("\n*", "\n *");
    if mechanism.is_ok() {
        text += &format!(
            " * int {prefix}_mass_and_bias(const double x[{d}], double mass[{}], double bias[{m}]);\n \
             *     0, 1 where x is outside the box, or 2 where g is singular: then mass and bias are 0\n",
            m * m
        );
    }
    text
}

fn series_tables(series: &Series<'_>, d: usize) -> String {
    let factors: usize = series.degrees.iter().map(|d| usize::from(*d)).sum::<usize>().max(1);
    let (outer, inner) = (series.outer.parents.len(), series.inner.parents.len());
    let mut text = format!(
        "\nstatic const unsigned short degrees[{d}] = {};\n",
        integers(&series.degrees, BRACES)
    );
    for (name, products) in [("outer", &series.outer), ("inner", &series.inner)] {
        let count = products.parents.len();
        text += &format!(
            "static const unsigned short {name}_parents[{count}] = {};\n\
             static const unsigned short {name}_factors[{count}] = {};\n",
            integers(&products.parents, BRACES),
            integers(&products.factors, BRACES)
        );
    }
    let mut calls = String::new();
    for (k, group) in series.groups.iter().enumerate() {
        let (blocks, entries) = (group.blocks.len(), group.entries.len());
        let flat: Vec<u16> = group.blocks.iter().flatten().copied().collect();
        text += &format!(
            "static const unsigned short entries_{k}[{entries}] = {};\n\
             static const unsigned short blocks_{k}[{}] = {};\n\
             static const double coefficients_{k}[{}][8] = {};\n",
            integers(&group.entries, BRACES),
            2 * blocks,
            integers(&flat, BRACES),
            blocks * entries,
            eights(&group.coefficients, BRACES)
        );
        calls += &format!(
            "    for (int b = 0; b < {blocks}; b++) {{\n        \
             const double *p = in + 8 * blocks_{k}[2 * b + 1];\n        \
             for (int e = 0; e < {entries}; e++) {{\n            \
             const double *c = coefficients_{k}[{entries} * b + e];\n            \
             double sum = 0.0;\n            \
             for (int i = 0; i < 8; i++) sum += c[i] * p[i];\n            \
             sums[entries_{k}[e]] += out[blocks_{k}[2 * b]] * sum;\n        }}\n    }}\n"
        );
    }
    text + &format!(
        "
/* sum of c_k T_k1(z_1) ... T_kd(z_d), products of polynomials as an outer one times an inner one */
static void add_series(const double *x, double *sums)
{{
    double t[{factors}], out[{outer}], in[{inner}];
    double *own = t;
    t[0] = 0.0;
    for (int i = 0; i < {d}; i++) {{
        const double z = (2.0 * x[i] - lower[i] - upper[i]) / (upper[i] - lower[i]);
        for (int k = 0; k < degrees[i]; k++)
            own[k] = k == 0 ? z : 2.0 * z * own[k - 1] - (k == 1 ? 1.0 : own[k - 2]);
        own += degrees[i];
    }}
    out[0] = in[0] = 1.0;
    for (int k = 1; k < {outer}; k++) out[k] = out[outer_parents[k]] * t[outer_factors[k]];
    for (int k = 1; k < {inner}; k++) in[k] = in[inner_parents[k]] * t[inner_factors[k]];
{calls}}}
"
    )
}

fn landmark_sum(sum: &LandmarkSum<'_>, k: usize, d: usize) -> String {
    let entries = sum.entries.len();
    let rows = d + entries;
    let tiles = sum.tiles.len() / rows;
    let term = if sum.profile.is_radial() {
        "s += (y[j] - tile[j][i]) * (y[j] - tile[j][i])"
    } else {
        "s += y[j] * tile[j][i]"
    };
    let profile = match sum.profile {
        Profile::Exponential => "const double v = exp(s);".to_owned(),
        Profile::Gaussian => "const double v = exp(-0.5 * s);".to_owned(),
        Profile::Power { offset, degree } => format!(
            "double v = 1.0;\n            for (unsigned q = 0; q < {degree}u; q++) v *= s + {};",
            number(offset)
        ),
        Profile::MaternHalf => "const double v = exp(-sqrt(s));".to_owned(),
        Profile::MaternThreeHalves => {
            "const double r = sqrt(3.0 * s), v = (1.0 + r) * exp(-r);".to_owned()
        }
        Profile::MaternFiveHalves => {
            "const double r = sqrt(5.0 * s), v = (1.0 + r + r * r / 3.0) * exp(-r);".to_owned()
        }
    };
    format!(
        "
static const unsigned short sum_entries_{k}[{entries}] = {};
static const double centre_{k}[{d}] = {};
static const double scale_{k}[{d}] = {};
static const double tiles_{k}[{}][8] = {};

/* sum of w_p psi(s_p), eight landmarks a tile: their coordinates, then their weights */
static void add_sum_{k}(const double *x, double *sums)
{{
    double y[{d}];
    for (int j = 0; j < {d}; j++) y[j] = (x[j] - centre_{k}[j]) * scale_{k}[j];
    for (int b = 0; b < {tiles}; b++) {{
        const double (*tile)[8] = tiles_{k} + {rows} * b;
        for (int i = 0; i < 8; i++) {{
            double s = 0.0;
            for (int j = 0; j < {d}; j++) {term};
            {profile}
            for (int e = 0; e < {entries}; e++) sums[sum_entries_{k}[e]] += v * tile[{d} + e][i];
        }}
    }}
}}
",
        integers(&sum.entries, BRACES),
        floats(&sum.centre, BRACES),
        floats(&sum.factors, BRACES),
        (rows * tiles).max(1),
        eights(&sum.tiles, BRACES),
    )
}

fn functions(prefix: &str, [d, n, m]: [usize; 3], calls: &str) -> String {
    let (all, size) = (n + n * m, (n * m).max(1));
    format!(
        "
int {prefix}_inside(const double x[{d}])
{{
    for (int i = 0; i < {d}; i++)
        if (!(lower[i] <= x[i] && x[i] <= upper[i])) return 0;
    return 1;
}}

int {prefix}_evaluate(const double x[{d}], double f[{n}], double g[{size}])
{{
    double nearest[{d}], sums[{all}];
    for (int i = 0; i < {d}; i++)
        nearest[i] = x[i] < lower[i] ? lower[i] : x[i] > upper[i] ? upper[i] : x[i];
    for (int k = 0; k < {all}; k++) sums[k] = 0.0;
{calls}    for (int k = 0; k < {n}; k++) f[k] = sums[k];
    for (int k = 0; k < {gs}; k++) g[k] = sums[{n} + k];
    return !{prefix}_inside(x);
}}
",
        gs = n * m
    )
}

fn mass_and_bias(prefix: &str, [d, n, m]: [usize; 3], first: usize) -> String {
    let (all, square, width) = (n * m, m * m, 2 * m);
    format!(
        "
int {prefix}_mass_and_bias(const double x[{d}], double mass[{square}], double bias[{m}])
{{
    double f[{n}], g[{all}], a[{m}][{width}];
    const int outside = {prefix}_evaluate(x, f, g);
    double largest = 0.0;
    for (int i = 0; i < {m}; i++)
        for (int j = 0; j < {m}; j++) {{
            const double v = g[({first} + i) * {m} + j];
            a[i][j] = v;
            a[i][{m} + j] = i == j;
            mass[i * {m} + j] = bias[i] = 0.0;
            if (v > largest || -v > largest) largest = v < 0.0 ? -v : v;
        }}
    /* Gauss and Jordan, by the largest pivot of each column */
    for (int k = 0; k < {m}; k++) {{
        int pivot = k;
        for (int i = k; i < {m}; i++)
            if (a[i][k] * a[i][k] > a[pivot][k] * a[pivot][k]) pivot = i;
        if (!(a[pivot][k] > 1e-12 * largest || -a[pivot][k] > 1e-12 * largest)) return 2;
        for (int j = 0; j < {width}; j++) {{
            const double v = a[pivot][j];
            a[pivot][j] = a[k][j];
            a[k][j] = v;
        }}
        const double inverse = 1.0 / a[k][k];
        for (int j = 0; j < {width}; j++) a[k][j] *= inverse;
        for (int i = 0; i < {m}; i++) {{
            const double factor = a[i][k];
            if (i != k)
                for (int j = 0; j < {width}; j++) a[i][j] -= factor * a[k][j];
        }}
    }}
    for (int i = 0; i < {m}; i++)
        for (int j = 0; j < {m}; j++) {{
            mass[i * {m} + j] = a[i][{m} + j];
            bias[i] -= a[i][{m} + j] * f[{first} + j];
        }}
    return outside;
}}
"
    )
}
