// Values under the pointer, a closer look, a choice of series, a button to copy. Names come from
// users' files: they are only ever set as text.
(() => {
  "use strict";
  const SVG = "http://www.w3.org/2000/svg";
  // Curves are written in tenths of the drawing's unit.
  const FINE = 10;
  const NARROWEST = 1 / 40;

  const element = (tag, parent, text, attributes = {}) => {
    const made = document.createElement(tag);
    if (text !== undefined) made.textContent = text;
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    if (parent) parent.append(made);
    return made;
  };
  const drawn = (tag, parent, attributes) => {
    const made = document.createElementNS(SVG, tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    if (parent) parent.append(made);
    return made;
  };
  const clamp = (v, low, high) => Math.min(high, Math.max(low, v));

  /// Pieces of a path: where each begins, then steps.
  const pieces = (d) =>
    d.split("M").slice(1).map((piece) => {
      const n = (piece.match(/-?\d+/g) || []).map(Number);
      const points = [];
      let x = 0, y = 0;
      for (let k = 0; k + 1 < n.length; k += 2) points.push([(x += n[k]), (y += n[k + 1])]);
      return points;
    });

  /// A number with the digits that a range drawn over so many steps has.
  const number = (value, range, steps) => {
    const step = range / steps;
    if (!(range > 0) || Math.abs(value) < step / 2) return "0";
    if (range >= 1e5 || range < 1e-3) return value.toExponential(3);
    return value.toFixed(clamp(Math.ceil(-Math.log10(step)), 0, 7));
  };

  /// Round values in a range, about five of them.
  const ticks = (from, to) => {
    const rough = (to - from) / 5;
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough);
    const all = [];
    for (let k = Math.ceil(from / step); k * step <= to + 1e-9 * step; k++) all.push(k * step);
    return { all, digits: clamp(-Math.floor(Math.log10(step) + 1e-9), 0, 9) };
  };

  class Plot {
    constructor(figure, group, serial) {
      this.figure = figure;
      this.group = group;
      this.svg = group.ownerSVGElement;
      const [left, top, right, bottom, x0, x1, y0, y1] = group.dataset.frame.split(" ").map(Number);
      Object.assign(this, { left, top, right, bottom, x0, x1, y0, y1 });
      this.width = FINE * (right - left);
      this.height = FINE * (bottom - top);
      this.zooms = figure.hasAttribute("data-time");
      this.whole = [0, this.width];
      this.view = this.whole;
      this.at = null;
      this.paths = [...group.querySelectorAll("path[data-label]")].map((path) => ({
        path,
        original: path.getAttribute("d"),
        band: path.classList.contains("band"),
        pieces: pieces(path.getAttribute("d")),
      }));
      this.clip = `lacuna-clip-${serial}`;
      this.linked = [this];
      this.furnish();
      this.listen();
    }

    furnish() {
      this.box = element("div", null, undefined, { class: "plot", tabindex: "0", role: "group" });
      const caption = this.figure.querySelector("figcaption");
      const keys = "arrow keys read values" + (this.zooms ? ", plus and minus zoom, Escape resets" : "");
      this.box.setAttribute("aria-label", `${caption ? caption.textContent : "Figure"}: ${keys}`);
      this.svg.replaceWith(this.box);
      this.box.append(this.svg);
      this.readout = element("div", this.box, undefined, { class: "readout", "aria-live": "polite" });
      this.readout.hidden = true;
      this.reset = element("button", this.box, "Whole range", { type: "button", class: "reset" });
      this.reset.hidden = true;
      const clip = drawn("clipPath", drawn("defs", this.group, {}), { id: this.clip });
      drawn("rect", clip, { width: this.width, height: this.height });
      const line = { stroke: "#33383F", "stroke-width": 2, "stroke-dasharray": "6 6", visibility: "hidden" };
      this.cross = drawn("line", this.svg, { ...line, y1: this.top, y2: this.bottom });
      const chosen = { fill: "#1F83C4", "fill-opacity": 0.2, visibility: "hidden" };
      this.chosen = drawn("rect", this.svg, { ...chosen, y: this.top, height: this.bottom - this.top });
      this.axis = this.svg.querySelector(".x-axis");
    }

    listen() {
      const svg = this.svg;
      svg.addEventListener("pointerdown", (e) => this.press(e));
      svg.addEventListener("pointermove", (e) => this.move(e));
      svg.addEventListener("pointerup", (e) => this.release(e));
      svg.addEventListener("pointercancel", () => this.drop());
      // A finger that is lifted leaves too; what it pointed at stays until it taps elsewhere.
      svg.addEventListener("pointerleave", (e) => {
        if (this.from === undefined && e.pointerType !== "touch") this.point(null);
      });
      svg.addEventListener("dblclick", () => this.zoom(this.whole));
      svg.addEventListener("wheel", (e) => this.wheel(e), { passive: false });
      this.box.addEventListener("keydown", (e) => this.key(e));
      this.box.addEventListener("blur", () => this.point(null));
      this.reset.addEventListener("click", () => this.zoom(this.whole));
    }

    /// Steps from the plane's left edge under the pointer.
    under(e) {
      const area = this.svg.getBoundingClientRect();
      const across = ((e.clientX - area.left) / area.width) * this.svg.viewBox.baseVal.width;
      return clamp(FINE * (across - this.left), 0, this.width);
    }

    /// Between steps on the screen and steps of the whole range.
    inside(step) {
      const [a, b] = this.view;
      return a + (step / this.width) * (b - a);
    }
    outside(step) {
      const [a, b] = this.view;
      return ((step - a) / (b - a)) * this.width;
    }
    value(step) {
      return this.x0 + (step / this.width) * (this.x1 - this.x0);
    }

    press(e) {
      if (e.button !== 0) return;
      this.point(this.inside(this.under(e)));
      if (!this.zooms) return;
      this.from = this.under(e);
      this.svg.setPointerCapture(e.pointerId);
    }

    move(e) {
      const at = this.under(e);
      this.point(this.inside(at));
      if (this.from === undefined) return;
      const low = Math.min(at, this.from) / FINE;
      this.chosen.setAttribute("x", this.left + low);
      this.chosen.setAttribute("width", Math.abs(at - this.from) / FINE);
      this.chosen.setAttribute("visibility", "visible");
    }

    release(e) {
      if (this.from === undefined) return;
      const ends = [this.from, this.under(e)].sort((a, b) => a - b);
      this.drop();
      if (ends[1] - ends[0] > this.width / 50) this.zoom(ends.map((s) => this.inside(s)));
    }

    drop() {
      this.from = undefined;
      this.chosen.setAttribute("visibility", "hidden");
    }

    wheel(e) {
      if (!this.zooms || !(e.ctrlKey || e.metaKey)) return;
      e.preventDefault();
      this.around(this.inside(this.under(e)), e.deltaY > 0 ? 1.25 : 0.8);
    }

    around(centre, factor) {
      this.zoom(this.view.map((end) => centre + (end - centre) * factor));
    }

    key(e) {
      if (e.target !== this.box || e.ctrlKey || e.metaKey || e.altKey) return;
      const [a, b] = this.view;
      const step = ((b - a) / 100) * (e.shiftKey ? 10 : 1);
      const at = this.at === null ? (a + b) / 2 : this.at;
      const go = { ArrowLeft: at - step, ArrowRight: at + step, Home: a, End: b }[e.key];
      if (go !== undefined) this.point(clamp(go, a, b));
      else if (this.zooms && (e.key === "+" || e.key === "=")) this.around(at, 0.7);
      else if (this.zooms && e.key === "-") this.around(at, 1 / 0.7);
      else if (e.key === "Escape") {
        this.zoom(this.whole);
        this.point(null);
      } else return;
      e.preventDefault();
    }

    /// Show the values at a step of the whole range; none hides them.
    point(at) {
      this.at = at;
      for (const plot of this.linked) plot.mark(at);
      this.readout.hidden = at === null;
      if (at === null) return;
      this.readout.replaceChildren();
      const [a, b] = this.view;
      const shown = this.value(b) - this.value(a);
      const x = number(this.value(at), shown, this.width);
      element("div", this.readout, `${this.group.dataset.x} ${x}`, { class: "at" });
      for (const entry of this.paths) this.row(entry, at);
      const middle = this.outside(at) > this.width / 2;
      const edge = (this.left + this.outside(at) / FINE) / this.svg.viewBox.baseVal.width;
      this.readout.style.left = middle ? "" : `calc(${100 * edge}% + .6rem)`;
      this.readout.style.right = middle ? `calc(${100 - 100 * edge}% + .6rem)` : "";
    }

    row(entry, at) {
      const colour = entry.path.getAttribute(entry.band ? "fill" : "stroke");
      const row = element("div", this.readout);
      const key = element("span", row, undefined, { class: entry.band ? "key band" : "key" });
      key.style.background = colour === "#33383F" ? "currentColor" : colour;
      element("span", row, `${entry.path.dataset.label} `);
      element("b", row, entry.band ? this.between(entry, at) : this.ordinate(entry, at));
    }

    mark(at) {
      const x = at === null ? -1 : this.outside(at);
      this.cross.setAttribute("visibility", x >= 0 && x <= this.width ? "visible" : "hidden");
      const across = this.left + x / FINE;
      this.cross.setAttribute("x1", across);
      this.cross.setAttribute("x2", across);
    }

    written(y) {
      const value = this.y1 - (y / this.height) * (this.y1 - this.y0);
      return number(value, this.y1 - this.y0, this.height);
    }

    /// The ordinate of a line at a step: on the segment there, none in a gap.
    ordinate(entry, at) {
      for (const points of entry.pieces) {
        if (points.length < 2 || at < points[0][0] || at > points[points.length - 1][0]) continue;
        const y = along(points, at);
        return y <= 0 || y >= this.height ? "beyond the picture" : this.written(y);
      }
      return "–";
    }

    between(entry, at) {
      for (const points of entry.pieces) {
        const lower = points.slice(0, points.length / 2);
        const upper = points.slice(points.length / 2).reverse();
        if (lower.length < 2 || at < lower[0][0] || at > lower[lower.length - 1][0]) continue;
        return `${this.written(along(lower, at))} to ${this.written(along(upper, at))}`;
      }
      return "–";
    }

    /// Narrow all linked figures to steps of the whole range.
    zoom([a, b]) {
      if (!this.zooms) return;
      const length = clamp(b - a, NARROWEST * this.width, this.width);
      const start = clamp((a + b - length) / 2, 0, this.width - length);
      for (const plot of this.linked) plot.show([start, start + length]);
    }

    show(view) {
      const whole = view[1] - view[0] > this.width - 1;
      this.view = whole ? this.whole : view;
      this.reset.hidden = whole;
      for (const entry of this.paths) entry.path.setAttribute("d", whole ? entry.original : this.cut(entry));
      if (whole) this.group.removeAttribute("clip-path");
      else this.group.setAttribute("clip-path", `url(#${this.clip})`);
      this.number(whole);
      this.mark(null);
    }

    cut(entry) {
      const far = 4 * this.width;
      const place = ([x, y]) => `${clamp(this.outside(x), -far, far).toFixed(0)} ${y}`;
      const seen = (p, k, all) => {
        const [before, after] = [all[k - 1] || p, all[k + 1] || p];
        return entry.band || (after[0] >= this.view[0] && before[0] <= this.view[1]);
      };
      const kept = entry.pieces.map((points) => points.filter(seen)).filter((p) => p.length);
      return kept.map((p) => "M" + p.map(place).join("L")).join("") + (entry.band ? "z" : "");
    }

    /// Ticks of the horizontal axis: those of the file for the whole range, else new ones.
    number(whole) {
      if (!this.axis) return;
      this.own ||= [...this.axis.children].filter((e) => this.moves(e));
      for (const e of this.own) e.style.display = whole ? "" : "none";
      for (const e of this.axis.querySelectorAll(".zoomed")) e.remove();
      if (whole) return;
      const label = this.own.find((e) => e.tagName === "text");
      const { all, digits } = ticks(this.value(this.view[0]), this.value(this.view[1]));
      for (const tick of all) {
        const step = ((tick - this.x0) / (this.x1 - this.x0)) * this.width;
        const x = this.left + this.outside(step) / FINE;
        const grid = { x1: x, x2: x, y1: this.top, y2: this.bottom, class: "zoomed" };
        drawn("line", this.axis, { ...grid, stroke: "#DDE1E6", "stroke-width": 2 });
        if (!label) continue;
        const copy = label.cloneNode();
        copy.textContent = tick.toFixed(digits);
        copy.setAttribute("x", x);
        copy.setAttribute("class", "zoomed");
        copy.style.display = "";
        this.axis.append(copy);
      }
    }

    /// Whether a part of the axis belongs to a tick: a vertical line, or a number.
    moves(e) {
      if (e.tagName === "text") return e.textContent.trim() !== this.group.dataset.x;
      const points = (e.getAttribute("points") || "").trim().split(/\s+/).map((p) => p.split(",")[0]);
      if (e.tagName === "line") return e.getAttribute("x1") === e.getAttribute("x2");
      return e.tagName === "polyline" && points.every((x) => x === points[0]);
    }
  }

  /// The ordinate of points in the order of their abscissas, between two of them.
  const along = (points, at) => {
    let [low, high] = [0, points.length - 1];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (points[middle][0] <= at) low = middle;
      else high = middle;
    }
    const [[x0, y0], [x1, y1]] = [points[low], points[high]];
    return x1 > x0 ? y0 + ((y1 - y0) * (at - x0)) / (x1 - x0) : y1;
  };

  /// A chooser shows one recording and channel at a time.
  const choose = (proofs) => {
    const all = [...proofs.querySelectorAll(".series")];
    const names = (key) => [...new Set(all.map((s) => s.dataset[key]))];
    if (all.length < 2) return;
    const bar = element("div", null, undefined, { class: "chooser" });
    const show = () => {
      for (const s of all) {
        s.hidden = choices.some(([key, select]) => select.value && JSON.parse(select.value) !== s.dataset[key]);
      }
    };
    const choices = [["recording", "Recording"], ["channel", "Channel"]]
      .filter(([key]) => names(key).length > 1)
      .map(([key, title]) => {
        const label = element("label", bar, `${title} `);
        const select = element("select", label);
        // Values are encoded, so that no name is taken for the choice of all.
        for (const name of names(key)) element("option", select, name, { value: JSON.stringify(name) });
        element("option", select, "all", { value: "" });
        select.addEventListener("change", show);
        return [key, select];
      });
    for (const [key, select] of choices) {
      if (key === "channel" && names(key).includes(proofs.dataset.first)) {
        select.value = JSON.stringify(proofs.dataset.first);
      }
    }
    proofs.prepend(bar);
    show();
  };

  const copying = (box) => {
    const text = box.querySelector("pre");
    const button = element("button", null, "Copy", { type: "button", class: "copying" });
    box.prepend(button);
    const tell = (words) => {
      button.textContent = words;
      setTimeout(() => (button.textContent = "Copy"), 2000);
    };
    button.addEventListener("click", async () => {
      try {
        await navigator.clipboard.writeText(text.textContent);
        tell("Copied");
      } catch {
        getSelection().selectAllChildren(text);
        tell(document.execCommand("copy") ? "Copied" : "Selected: press Ctrl+C");
      }
    });
  };

  const groups = document.querySelectorAll("figure g.curves[data-frame]");
  const plots = [...groups].map((g, k) => new Plot(g.closest("figure"), g, k));
  for (const plot of plots) {
    const family = plot.figure.closest(".series");
    const same = (p) => p.x0 === plot.x0 && p.x1 === plot.x1 && p.group.dataset.x === plot.group.dataset.x;
    if (family) plot.linked = plots.filter((p) => p.figure.closest(".series") === family && same(p));
  }
  document.querySelectorAll(".proofs").forEach(choose);
  document.querySelectorAll(".copy").forEach(copying);
  for (const hint of document.querySelectorAll(".hint")) hint.hidden = false;
})();
