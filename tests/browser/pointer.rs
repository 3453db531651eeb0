//! What pages do for a pointer, a keyboard and a choice.

use crate::tab::Tab;
use serde_json::{Value, json};

/// The first figure that answers a pointer: its plane's box on the screen, what its readout says
/// and the labels of its lines.
const FIGURE: &str = r#"(() => {
  const curves = [...document.querySelectorAll("figure g.curves[data-frame]")]
    .find(g => g.ownerSVGElement.getBoundingClientRect().width > 0);
  const svg = curves.ownerSVGElement, plot = svg.closest(".plot");
  svg.scrollIntoView({ block: "center", behavior: "instant" });
  const [left, top, right, bottom, x0, x1] = curves.dataset.frame.split(" ").map(Number);
  const area = svg.getBoundingClientRect(), scale = area.width / svg.viewBox.baseVal.width;
  const readout = plot.querySelector(".readout"), shown = readout.getBoundingClientRect();
  return {
    plot, x0, x1,
    left: area.left + scale * left, right: area.left + scale * right,
    middle: area.top + scale * (top + bottom) / 2,
    seen: shown.width > 0 && shown.height > 0 && shown.left >= 0
      && shown.right <= document.documentElement.clientWidth,
    says: readout.textContent,
    at: Number((readout.querySelector(".at")?.textContent ?? "").split(" ").pop()),
    labels: [...curves.querySelectorAll("path.line")].map(p => p.dataset.label),
  };
})()"#;

fn figure(tab: &mut Tab) -> Value {
    let mut figure = tab.evaluate(&format!("({{ ...{FIGURE}, plot: null }})"));
    figure["at"] = figure["at"].as_f64().map_or(json!(0.0), |at| json!(at));
    figure
}

fn number(figure: &Value, key: &str) -> f64 {
    figure[key].as_f64().unwrap_or_else(|| panic!("no number '{key}': {figure}"))
}

/// Values under the pointer, at shares of the figure's width.
pub fn pointer(tab: &mut Tab) -> Vec<String> {
    let mut out = vec![];
    for share in [0.25, 0.75] {
        let f = figure(tab);
        let (left, right) = (number(&f, "left"), number(&f, "right"));
        move_to(tab, left + share * (right - left), number(&f, "middle"));
        let f = figure(tab);
        if f["seen"] != true {
            out.push(format!("no values under the pointer: {f}"));
            continue;
        }
        let (x0, x1) = (number(&f, "x0"), number(&f, "x1"));
        let there = (number(&f, "at") - x0) / (x1 - x0);
        if (there - share).abs() > 0.01 {
            out.push(format!("at {share} of the width the values are those at {there}"));
        }
        out.extend(values(&f));
    }
    move_to(tab, 1.0, 1.0);
    if figure(tab)["seen"] == true {
        out.push("values stay when the pointer has gone".to_owned());
    }
    out
}

/// A number, or a word why there is none, after the label of each line.
fn values(figure: &Value) -> Option<String> {
    let said = figure["says"].as_str().unwrap_or_default();
    let labels = figure["labels"].as_array().into_iter().flatten().filter_map(Value::as_str);
    let value = |label: &str| -> Option<char> {
        said.split_once(label)?.1.trim_start().trim_start_matches(['-', '−']).chars().next()
    };
    let without =
        |label: &&str| !value(label).is_some_and(|c| c.is_ascii_digit() || c == 'b' || c == '–');
    let silent: Vec<&str> = labels.filter(without).collect();
    let some = said.chars().any(|c| c.is_ascii_digit());
    (!silent.is_empty() || !some).then(|| format!("no values of {silent:?} in '{said}'"))
}

fn move_to(tab: &mut Tab, x: f64, y: f64) {
    tab.call("Input.dispatchMouseEvent", json!({"type": "mouseMoved", "x": x, "y": y}));
}

/// Values at the keys of a figure that has the focus.
pub fn keyboard(tab: &mut Tab) -> Vec<String> {
    tab.evaluate(&format!("({FIGURE}).plot.focus()"));
    let mut after = |key: &str, code: u32| {
        for kind in ["rawKeyDown", "keyUp"] {
            let key = json!({"type": kind, "key": key, "code": key, "windowsVirtualKeyCode": code});
            tab.call("Input.dispatchKeyEvent", key);
        }
        figure(tab)
    };
    let (first, second) = (after("ArrowRight", 39), after("ArrowRight", 39));
    let third = after("ArrowLeft", 37);
    let gone = after("Escape", 27);
    let at = [&first, &second, &third].map(|f| number(f, "at"));
    let mut out: Vec<String> = [&first, &second, &third].into_iter().filter_map(values).collect();
    if first["seen"] != true || !(at[1] > at[0] && at[2] < at[1]) {
        out.push(format!("arrow keys lead to {at:?}"));
    }
    if gone["seen"] == true {
        out.push("values stay after Escape".to_owned());
    }
    out
}

/// Another recording shows its figures alone; all of them are there for the asking.
pub fn choice(tab: &mut Tab) -> Vec<String> {
    const SHOWN: &str = r#"(() => {
      const series = [...document.querySelectorAll(".proofs .series")];
      return series.filter(s => s.getBoundingClientRect().height > 0).map(s => s.dataset.recording);
    })()"#;
    let first = tab.evaluate("document.querySelectorAll('.proofs .series')[0].dataset.recording");
    let last =
        tab.evaluate("[...document.querySelectorAll('.proofs .series')].pop().dataset.recording");
    let mut choose = |name: &Value| {
        let wanted = name.as_str().unwrap_or("all");
        // As a reader does: the entry of that name, and the event that follows.
        let chosen = format!(
            "(() => {{ const select = document.querySelector('.proofs .chooser select');\
               const at = select ? [...select.options].findIndex(o => o.text === {}) : -1;\
               if (at >= 0) {{ select.selectedIndex = at; select.dispatchEvent(new Event('change')); }}\
               return at >= 0; }})()",
            json!(wanted)
        );
        match tab.evaluate(&chosen) == true {
            true => tab.evaluate(SHOWN),
            false => json!(format!("'{wanted}' cannot be chosen")),
        }
    };
    let (at_first, at_last, all) = (choose(&first), choose(&last), choose(&Value::Null));
    let expected = [json!([first]), json!([last]), json!([first, last])];
    let found = [at_first, at_last, all];
    if found == expected { vec![] } else { vec![format!("expected {expected:?}, found {found:?}")] }
}
