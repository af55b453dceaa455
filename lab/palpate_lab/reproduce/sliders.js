// Draws and interpolates the numbers in DATA; computes nothing of its own.
"use strict";
const $ = (id) => document.getElementById(id);
const COLORS = { "approach-velocity": "#c8453b", "paper-alg1": "#b58900", "face-normal": "#8767a8", "paper-plane": "#4f8f4f", proxy: "#1f6f8b" };
const line = (x1, y1, x2, y2, color, width = 2, dash = "") =>
  `<line x1="${x1}" y1="${y1}" x2="${x2}" y2="${y2}" stroke="${color}" stroke-width="${width}" stroke-dasharray="${dash}"/>`;
const text = (x, y, words, kind = "", anchor = "start", color = "") =>
  `<text x="${x}" y="${y}" class="${kind}" text-anchor="${anchor}"${color ? ` style="fill:${color}"` : ""}>${words}</text>`;
const arrow = (x, y, dx, dy, color, width = 2.5) => {
  const l = Math.hypot(dx, dy) || 1, ux = dx / l, uy = dy / l, ex = x + dx, ey = y + dy;
  return line(x, y, ex - 6 * ux, ey - 6 * uy, color, width) +
    `<polygon fill="${color}" points="${ex},${ey} ${ex - 10 * ux - 4.5 * uy},${ey - 10 * uy + 4.5 * ux} ${ex - 10 * ux + 4.5 * uy},${ey - 10 * uy - 4.5 * ux}"/>`;
};

// Value at x between two neighbouring rows, linearly.
function between(rows, key, x, name) {
  const sorted = [...rows].sort((a, b) => a[key] - b[key]);
  const i = Math.max(1, sorted.findIndex((row) => row[key] >= x));
  const [a, b] = [sorted[i - 1], sorted[i]], share = (x - a[key]) / (b[key] - a[key] || 1);
  return a[name] + share * (b[name] - a[name]);
}

function approach() {
  const angle = +$("angle").value, methods = [...new Set(DATA.approach.map((row) => row.method))];
  $("angle-out").textContent = `${angle}°`;
  const cx = 230, cy = 330, r = 150, top = cy - r, rad = Math.PI / 180;
  let svg = `<circle cx="${cx}" cy="${cy}" r="${r}" fill="#e3b7a5" opacity="0.55"/>`;
  svg += `<circle cx="${cx}" cy="${top - 16}" r="26" fill="none" stroke="#1f6f8b" stroke-width="1.5"/>`;
  svg += line(cx + 230 * Math.sin(angle * rad), top - 16 - 230 * Math.cos(angle * rad), cx, top - 16, "#71808c", 1.5, "5 4");
  svg += text(cx + 150 * Math.sin(angle * rad) + 10, Math.max(top - 10 - 150 * Math.cos(angle * rad), 20), "way of the tool", "small");
  methods.forEach((method, i) => {
    const off = between(DATA.approach.filter((row) => row.method === method), "approach_deg", angle, "normal_error_deg");
    const tilt = off * rad;
    svg += arrow(cx, top - 16, 112 * Math.sin(tilt), -112 * Math.cos(tilt), COLORS[method], i === methods.length - 1 ? 4 : 2.5);
    const y = 60 + 40 * i;
    svg += text(530, y + 4, method, "", "end", COLORS[method]);
    svg += `<rect x="545" y="${y - 9}" width="${Math.max(3.4 * off, 1)}" height="18" fill="${COLORS[method]}"/>`;
    svg += text(555 + 3.4 * off, y + 4, `${off < 0.01 ? "below 0.01" : off.toFixed(off < 1 ? 2 : 1)}°`);
  });
  svg += text(545, 30, "error of the normal", "small") + text(20, 24, "arrows: normal of each method, tilted by its error", "small");
  $("approach").innerHTML = svg;
}

function gap() {
  const pair = DATA.gap.pairs[+$("gap").value], scale = 4.2, at = ([x, z]) => [190 + scale * x, 235 - scale * z];
  const size = pair.gap_mm >= 0.01 ? `${pair.gap_mm.toPrecision(3)} mm` : `${(1e6 * pair.gap_mm).toPrecision(3)} nm`;
  $("gap-out").textContent = size;
  const shape = (points, [dx, dz], color) =>
    `<polygon fill="${color}" opacity="0.7" stroke="#71808c" points="${points.map(([x, z]) => at([x + dx, z + dz]).join()).join(" ")}"/>`;
  let svg = shape(DATA.gap.U, [0, 0], "#e3b7a5") + shape(DATA.gap.V, pair.p_V, "#bcd4de");
  for (const [p, n, color, name] of [[pair.x, pair.n_U, "#c8453b", "n_U"], [pair.y, pair.n_V, "#1f6f8b", "n_V"]]) {
    const [x, y] = at(p);
    svg += arrow(x, y, 62 * n[0], -62 * n[1], color) + text(x + 76 * n[0], y - 76 * n[1], name, "", "middle", color);
  }
  svg += text(560, 70, `|n_U × n_V| = ${pair.cross.toExponential(2)}`) + text(560, 95, `n_U · n_V = −1 + ${(1 + pair.dot).toExponential(2)}`);
  svg += line(560, 290, 860, 290, "#b9c3cb", 1) + line(560, 130, 560, 290, "#b9c3cb", 1);
  const px = (g) => 860 + 50 * (Math.log10(g) - 1), py = (c) => 290 + 22 * (Math.log10(c) + 7) * -1;
  svg += `<polyline fill="none" stroke="#c8453b" stroke-width="2" points="${DATA.gap.pairs.map((q) => `${px(q.gap_mm)},${py(q.cross)}`).join(" ")}"/>`;
  svg += `<circle cx="${px(pair.gap_mm)}" cy="${py(pair.cross)}" r="5" fill="#c8453b"/>`;
  svg += text(710, 316, "gap, 10 nm to 10 mm (log)", "small", "middle") + text(566, 128, "|n_U × n_V| (log)", "small");
  $("pair").innerHTML = svg;
}

function noise() {
  const level = +$("noise").value, caps = Object.keys(DATA.noise[0]).filter((key) => key.startsWith("error_filtered"));
  const cap = caps[+$("cap").value], words = cap.match(/at_(.*)_N_per_s/)[1];
  $("noise-out").textContent = `${level.toFixed(2)} mm`;
  $("cap-out").textContent = `${words} N/s`;
  const radii = [...new Set(DATA.noise.map((row) => row.radius_mm))].sort((a, b) => a - b);
  const rows = radii.map((radius) => {
    const mine = DATA.noise.filter((row) => row.radius_mm === radius), value = (name) => between(mine, "noise_mm", level, name);
    return { radius, turned: value("direction_deg"), raw: value("error_mN"), filtered: value(cap), kept: between(mine, "noise_mm", 0, "kept_of_the_relief") };
  });
  const most = Math.max(300, ...rows.map((row) => row.raw)), height = (x) => (190 * x) / most;
  let svg = line(60, 220, 880, 220, "#b9c3cb", 1);
  rows.forEach((row, i) => {
    const x = 90 + 160 * i;
    svg += `<rect x="${x}" y="${220 - height(row.raw)}" width="46" height="${height(row.raw)}" fill="#c8453b"/>`;
    svg += `<rect x="${x + 52}" y="${220 - height(row.filtered)}" width="46" height="${height(row.filtered)}" fill="#1f6f8b"/>`;
    svg += text(x + 23, 214 - height(row.raw), row.raw.toFixed(0), "small", "middle") + text(x + 75, 214 - height(row.filtered), row.filtered.toFixed(0), "small", "middle");
    svg += text(x + 49, 240, `radius ${row.radius.toFixed(1)} mm`, "", "middle");
  });
  svg += text(60, 16, "error of the force [mN]:", "small") + text(210, 16, "without filter", "", "start", "#c8453b") + text(310, 16, `with a cap of ${words} N/s`, "", "start", "#1f6f8b");
  $("bars").innerHTML = svg;
  $("remedies").innerHTML = "<tr><th>radius</th><th>direction turned by</th><th>8 mm ridges rendered</th></tr>" +
    rows.map((row) => `<tr><td>${row.radius.toFixed(1)} mm</td><td>${row.turned.toFixed(1)}°</td><td>${(100 * row.kept).toFixed(0)} %</td></tr>`).join("");
}

for (const [id, draw] of [["angle", approach], ["gap", gap], ["noise", noise], ["cap", noise]]) $(id).addEventListener("input", draw);
approach(); gap(); noise();
