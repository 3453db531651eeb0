// An expression: what a reader sees of a page, as lists of complaints.
({
  // Boxes of every line of text that is drawn.
  texts() {
    const found = [];
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    while (walker.nextNode()) {
      const node = walker.currentNode, element = node.parentElement;
      if (!node.data.trim() || element.closest("style,script,title,desc")) continue;
      // Headings of a table that are there for screen readers alone.
      if (this.ancestors(element).some(e => getComputedStyle(e).clipPath !== "none")) continue;
      const range = document.createRange();
      range.selectNodeContents(node);
      found.push({ element, text: node.data.trim().slice(0, 60), boxes: [...range.getClientRects()] });
    }
    return found;
  },

  ancestors(element) {
    const all = [];
    for (let e = element; e; e = e.parentElement) all.push(e);
    return all;
  },

  // Whether the reader can scroll to what is beyond an element's edge.
  scrolls(element) {
    return this.ancestors(element).some(e =>
      e.tagName === "PRE" && ["auto", "scroll"].includes(getComputedStyle(e).overflowX));
  },

  overflow() {
    const root = document.documentElement, width = root.clientWidth, out = [];
    if (root.scrollWidth > width) out.push(`the page is ${root.scrollWidth} px wide in ${width} px`);
    for (const { element, text, boxes } of this.texts()) {
      const beyond = boxes.find(b => b.width > 0 && (b.left < -0.5 || b.right > width + 0.5));
      if (beyond && !this.scrolls(element)) {
        out.push(`'${text}' from ${beyond.left} to ${beyond.right} px in ${width} px`);
      }
    }
    return out;
  },

  // Elements that `selector` names and that have no box; `some` asks for one of them alone.
  hidden(selector) {
    return [...document.querySelectorAll(selector)].filter(e => {
      const b = e.getBoundingClientRect();
      return !(b.width > 0 && b.height > 0) || getComputedStyle(e).visibility === "hidden";
    });
  },

  figures(all) {
    const figures = [...document.querySelectorAll("svg.lacuna-figure")], out = [];
    if (!figures.length) out.push("the page has no figure");
    const hidden = this.hidden("svg.lacuna-figure");
    if (all && hidden.length) out.push(`${hidden.length} of ${figures.length} figures are hidden`);
    if (hidden.length === figures.length) out.push("no figure is seen");
    for (const figure of figures) {
      const title = figure.querySelector(":scope > title");
      if (!title || !title.textContent.trim()) out.push("a figure without a title");
      const b = figure.getBoundingClientRect();
      if (!hidden.includes(figure) && (b.width < 200 || b.height < 100)) {
        out.push(`a figure of ${b.width} x ${b.height} px`);
      }
    }
    return out;
  },

  // The page can be read: headings, tables and text have their boxes, save in `skipped`.
  readable(skipped) {
    const out = [];
    for (const kind of ["h1", "h2", "table", "main section"]) {
      const count = document.querySelectorAll(kind).length, hidden = this.hidden(kind).length;
      if (!count || hidden) out.push(`${hidden} of ${count} '${kind}' are hidden`);
    }
    for (const { element, text, boxes } of this.texts()) {
      const seen = boxes.some(b => b.width > 0 && b.height > 0);
      if (!seen && !element.closest(`svg,option,${skipped}`)) out.push(`'${text}' is hidden`);
    }
    return out;
  },

  colour(text) {
    const n = (text.match(/[\d.]+/g) || []).map(Number);
    return { rgb: n.slice(0, 3), alpha: text.startsWith("rgb") ? (n.length > 3 ? n[3] : 1) : 0 };
  },

  // `top` laid over the colour `under`.
  over(top, under) {
    return under.map((u, k) => top.alpha * top.rgb[k] + (1 - top.alpha) * u);
  },

  ground(element) {
    const dark = matchMedia("(prefers-color-scheme: dark)").matches;
    const sheets = this.ancestors(element).reverse();
    return sheets.reduce(
      (under, e) => this.over(this.colour(getComputedStyle(e).backgroundColor), under),
      dark ? [18, 18, 18] : [255, 255, 255]);
  },

  luminance(rgb) {
    const linear = rgb.map(v => v / 255).map(v => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
  },

  // Text whose contrast (WCAG 2) against its ground is below 4.5, one of each kind.
  contrast() {
    const out = new Map();
    let seen = 0;
    for (const { element, text, boxes } of this.texts()) {
      if (!boxes.some(b => b.width > 0)) continue;
      seen += 1;
      const style = getComputedStyle(element), ground = this.ground(element);
      const ink = element.closest("svg") ? style.fill : style.color;
      const [a, b] = [this.over(this.colour(ink), ground), ground].map(c => this.luminance(c));
      const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
      if (ratio < 4.5) out.set(`${ink} on ${ground}`, `'${text}': ${ink} on rgb(${ground}) has ${ratio.toFixed(2)}`);
    }
    return seen < 20 ? [`only ${seen} texts are seen`] : [...out.values()];
  },

  print() {
    const out = [...document.querySelectorAll("nav")].length === this.hidden("nav").length ? [] : ["nav is printed"];
    return out.concat(this.readable("nav,button,.hint,.chooser,[hidden]"));
  },
})
