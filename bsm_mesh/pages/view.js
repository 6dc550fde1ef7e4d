// Shows a state of the results. Bokeh calls this for every change of a widget, every click and every size of the plot.
//
// Given by view_page.py: `data` (numbers), `parts` (what is drawn of each kind), `memory` (stays between
// calls), `plot`, `down`, `chosen` (marks), the widgets `frame`, `stage`, `factor`, `shown`, `told`, and `falls_source`.
// Dictionaries of Python are objects here, arrays are typed arrays.
"use strict"

const frames = data.frames
const state = frames[Math.round(frame.value)]
const [x0, y0] = data.middle
const times = Number(factor.value)
const LINES = ["bolts", "water"].filter((kind) => kind in parts)
const CLICKED = ["bolts", "joints", "blocks"].filter((kind) => kind in parts) // what lies above comes first
const MARGIN = 1.06 // of the model, round it
const SHADES = 32 // of joints
const AT_ONCE = 400 // joints: longer paths take more than their share of time
const STRIDE = 3 // both ends of a joint and the gap after it
const NEAR = 12 // sizes of a block that are seen when it is looked for
const ROUNDING = 1e-9 // of the greatest value: less is told as 0
const PREFIXES = [[1e9, 1e9, "G"], [1e6, 1e6, "M"], [1e3, 1e3, "k"], [1, 1, ""], [1e-6, 1e-3, "m"], [0, 1e-6, "u"]]

// ------------------------------------------------------------------------------------------------------- texts

function escaped(text) {
  return String(text).replace(/[&<>"']/g, (c) => `&#${c.charCodeAt(0)};`)
}

function prefix(value, unit) {
  const [, by, letter] = unit === "" || unit === "m2" || value === 0 ? [1, 1, ""] : PREFIXES.find(([least]) => Math.abs(value) >= least)
  return [by, `${letter}${unit}`]
}

function engineering(value, unit) {
  const [by, prefixed] = prefix(value, unit)
  return `${Number((value / by).toPrecision(4))} ${prefixed}`.trim()
}

function value_text(kind, name, value) {
  const names = data.names[kind]?.[name]
  if (names !== undefined) { return names[value] }
  if (!Number.isFinite(value)) { return "not known" }
  const greatest = state[kind].arrays[name].reduce((most, one) => (Math.abs(one) > most ? Math.abs(one) : most), 0)
  return engineering(Math.abs(value) > ROUNDING * greatest ? value : 0, data.units[kind][name])
}

// ------------------------------------------------------------------------------------------------------ colours

// The scale of colours of an array is one for all states. Blocks that come down are kept out of it, outliers too.
function scale_of(kind, name) {
  const key = `${kind} ${name}`
  if (memory[key] === undefined) {
    memory[key] = name === "none" ? plain(kind) : data.names[kind]?.[name] !== undefined ? named(kind, name) : ranged(kind, name)
  }
  return memory[key]
}

function plain(kind) {
  return {palette: [kind === "blocks" ? data.paper : "#333333"], low: 0, high: 1, by: 1, title: "", names: []}
}

function named(kind, name) {
  const names = data.names[kind][name]
  const colours = name === "status" ? data.states[kind] : data.colours
  const palette = names.map((_, k) => (name === "unstable" ? [data.paper, "#d55e00"][k] : colours[k % colours.length]))
  return {palette, low: -0.5, high: names.length - 0.5, by: 1, title: `${kind}: ${name}`, names}
}

function ranged(kind, name) {
  const all = []
  for (const one of frames) {
    const values = one[kind]?.arrays[name] ?? []
    const out = new Set(kind === "blocks" ? one.unstable : [])
    values.forEach((value, k) => { if (Number.isFinite(value) && !out.has(k)) { all.push(value) } })
  }
  const sorted = Float64Array.from(all).sort()
  const at = (part) => (sorted.length ? sorted[Math.round(part * (sorted.length - 1))] : 0)
  let [low, high] = [at(0), at(1)]
  let title = `${kind}: ${name}`
  if (high - low > 2 * (at(0.99) - at(0.01)) && at(0.99) > at(0.01)) {
    [low, high] = [at(0.01), at(0.99)]
    title += " (1st to 99th percentile)"
  }
  const [by, unit] = prefix(Math.max(Math.abs(low), Math.abs(high)), data.units[kind][name])
  const least = Math.max(Math.abs(low) * 1e-6, 1e-300)
  const palette = data.palettes[kind]
  return {palette, low: low / by, high: Math.max(high, low + least) / by, by, title: unit ? `${title}, ${unit}` : title, names: []}
}

// From three to eight numbers of one or two digits.
function round_numbers(low, high) {
  const power = 10 ** Math.floor(Math.log10(high - low))
  const step = [0.2, 0.5, 1, 2].map((part) => part * power).find((one) => (high - low) / one < 8)
  const [first, last] = [Math.ceil(low / step - 1e-9), Math.floor(high / step + 1e-9)]
  return Array.from({length: last - first + 1}, (_, k) => Number(((first + k) * step).toPrecision(12)))
}

function colours_of(kind, count) {
  const part = parts[kind]
  const name = part.by.value
  const scale = scale_of(kind, name)
  if (part.painted !== name) {
    part.mapper.setv({palette: scale.palette, low: scale.low, high: scale.high})
    part.bar.ticker.ticks = scale.names.length ? scale.names.map((_, k) => k) : round_numbers(scale.low, scale.high)
    part.bar.setv({title: scale.title, major_label_overrides: new Map(scale.names.map((text, k) => [k, text]))})
    part.painted = name
  }
  const values = state[kind]?.arrays[name]
  return Float64Array.from({length: count}, (_, k) => (values === undefined ? 0 : values[k] / scale.by))
}

// ------------------------------------------------------------------------------------------------------- shapes

// Corners of a block where it is, its movement from where it was given taken `times`; nothing where it is not there.
function outline(block, motion) {
  const [first, last] = [data.offsets[block], data.offsets[block + 1]]
  const [u, v, turn] = motion.map((values) => values[block])
  if (!Number.isFinite(u)) { return [new Float64Array(0), new Float64Array(0)] }
  const [versed, sine] = [-2 * Math.sin(turn / 2) ** 2, Math.sin(turn)]
  const [cx, cy] = [data.centroid_x[block], data.centroid_y[block]]
  const [xs, ys] = [new Float64Array(last - first), new Float64Array(last - first)]
  for (let k = first; k < last; k++) {
    const [x, y] = [data.x[k], data.y[k]]
    const [dx, dy] = [x - cx, y - cy]
    xs[k - first] = x0 + x + times * (u + versed * dx - sine * dy)
    ys[k - first] = y0 + y + times * (v + sine * dx + versed * dy)
  }
  return [xs, ys]
}

function motion_of(one) {
  return ["displacement x", "displacement y", "rotation"].map((name) => one.blocks.arrays[name])
}

function draw_blocks() {
  const count = data.area.length
  const motion = motion_of(state)
  const [xs, ys] = [new Array(count), new Array(count)]
  for (let block = 0; block < count; block++) { [xs[block], ys[block]] = outline(block, motion) }
  parts.blocks.source.data = {xs, ys, shown: colours_of("blocks", count)}
}

function line(kind, k) {
  const [ends, moved] = [state[kind].ends, state[kind].moved]
  return [0, 1, 2, 3].map((c) => (c % 2 ? y0 : x0) + ends[4 * k + c] + times * moved[4 * k + c])
}

function draw_lines(kind) {
  const count = (kind in state) ? state[kind].ends.length / 4 : 0
  const columns = [0, 1, 2, 3].map(() => new Float64Array(count))
  for (let k = 0; k < count; k++) { line(kind, k).forEach((value, c) => { columns[c][k] = value }) }
  const [a, b, c, d] = columns
  const lines = {x0: a, y0: b, x1: c, y1: d}
  if (kind !== "water") { lines.shown = colours_of(kind, count) }
  parts[kind].source.data = lines
}

// Joints of a colour as a few long lines with gaps, which are drawn in two thirds of the time of as many lines.
function draw_joints() {
  const count = state.joints.ends.length / 4
  const values = colours_of("joints", count)
  const {low, high, names} = scale_of("joints", parts.joints.by.value)
  const rows = Array.from({length: names.length || SHADES}, () => [])
  const of = (value) => Math.floor(((value - low) / (high - low)) * rows.length)
  values.forEach((value, k) => rows[Math.min(Math.max(of(value), 0), rows.length - 1)].push(k))
  const used = []
  rows.forEach((ids, row) => {
    for (let k = 0; k < ids.length; k += AT_ONCE) {
      used.push([ids.slice(k, k + AT_ONCE), low + ((row + 0.5) / rows.length) * (high - low)])
    }
  })
  const [xs, ys] = [[], []]
  for (const [ids] of used) {
    const [x, y] = [new Float64Array(STRIDE * ids.length).fill(NaN), new Float64Array(STRIDE * ids.length).fill(NaN)]
    ids.forEach((id, k) => {
      const [a, b, c, d] = line("joints", id)
      x.set([a, c], STRIDE * k)
      y.set([b, d], STRIDE * k)
    })
    xs.push(x)
    ys.push(y)
  }
  memory.rows = used.map(([ids]) => ids)
  parts.joints.source.data = {xs, ys, shown: used.map(([, value]) => value)}
}

// What was clicked: the nearest joint is the last that Bokeh found.
function clicked() {
  const kind = CLICKED.find((one) => parts[one].source.selected.indices.length > 0)
  if (kind !== "joints") { return [kind, kind && parts[kind].source.selected.indices[0]] }
  const [row, [point]] = [...parts.joints.source.selected.multiline_indices].at(-1)
  return [kind, memory.rows[row][Math.floor(point / STRIDE)]]
}

function draw_marks() {
  const found = Array.from(state.unstable)
  const shapes = found.map((block) => outline(block, motion_of(state)))
  const middle = (values) => values.reduce((sum, value) => sum + value, 0) / values.length
  down.data = {
    xs: shapes.map(([xs]) => xs),
    ys: shapes.map(([, ys]) => ys),
    x: shapes.map(([xs]) => middle(xs)),
    y: shapes.map(([, ys]) => middle(ys)),
    text: found.map(String),
  }
  const one = memory.chosen
  let ends = []
  if (one?.kind === "blocks") {
    const [xs, ys] = outline(one.index, motion_of(state))
    ends = xs.length ? [[[...xs, xs[0]], [...ys, ys[0]]]] : []
  } else if (one !== undefined && one.index >= 0 && one.kind in state) {
    const [a, b, c, d] = line(one.kind, one.index)
    ends = [[[a, c], [b, d]]]
  }
  chosen.data = {xs: ends.map(([xs]) => xs), ys: ends.map(([, ys]) => ys)}
}

// ------------------------------------------------------------------------------------------------ what is chosen

function choose(kind, index) {
  if (kind === undefined) { memory.chosen = undefined; return }
  const one = {kind, index}
  if (kind === "joints") {
    const layer = state[kind]
    one.blocks = [layer.which[2 * index], layer.which[2 * index + 1]]
    one.ends = layer.ends.slice(4 * index, 4 * index + 4)
  }
  memory.chosen = one
}

// The face of the same blocks that is nearest, where a state has other faces; none: -1.
function find_again() {
  const one = memory.chosen
  if (one?.kind !== "joints") { return }
  const [which, ends] = [state.joints.which, state.joints.ends]
  const [a, b] = one.blocks
  let nearest = Infinity
  one.index = -1
  for (let k = 0; 2 * k < which.length; k++) {
    const [c, d] = [which[2 * k], which[2 * k + 1]]
    if (!((a === c && b === d) || (a === d && b === c))) { continue }
    const there = [0, 1].map((i) => ends[4 * k + i] + ends[4 * k + 2 + i] - one.ends[i] - one.ends[2 + i])
    if (Math.hypot(...there) < nearest) { [nearest, one.index] = [Math.hypot(...there), k] }
  }
}

function tell() {
  const one = memory.chosen
  if (one === undefined) { told.text = "<i>Nothing is chosen.</i>"; return }
  const {kind, index} = one
  const rows = []
  let name = ""
  if (kind === "blocks") {
    name = `Block ${index}, ${data.rock_names[data.rock[index]]}`
    const [x, y] = [data.centroid_x[index] + x0, data.centroid_y[index] + y0]
    rows.push(["area", engineering(data.area[index], "m2")], ["given at", `(${x.toFixed(3)}, ${y.toFixed(3)}) m`])
  } else if (kind === "joints") {
    name = `Joint between blocks ${one.blocks[0]} and ${one.blocks[1]}`
  } else if ("bolts" in state) {
    name = `Bolt ${data.bolt_names[state.bolts.which[2 * index]]}`
  }
  const arrays = index < 0 ? undefined : state[kind]?.arrays
  const there = arrays !== undefined && (kind !== "blocks" || Number.isFinite(motion_of(state)[0][index]))
  if (there) { for (const [array, values] of Object.entries(arrays)) { rows.push([array, value_text(kind, array, values[index])]) } }
  const table = rows.map((cells) => `<tr>${cells.map((cell) => `<td>${escaped(cell)}</td>`).join("")}</tr>`).join("")
  told.text = `<b>${escaped(name || "Bolt")}</b>${there ? "" : " is not there in this state"}<table>${table}</table>`
}

// -------------------------------------------------------------------------------------------------- what is seen

function see(x, y, metres) {
  const [width, height] = [plot.inner_width, plot.inner_height].map((pixels) => (pixels * metres) / 2)
  plot.x_range.setv({start: x - width, end: x + width})
  plot.y_range.setv({start: y - height, end: y + height})
}

// A metre is as long along y as along x. The whole model is seen at first, and by Reset.
function fit() {
  const [width, height] = [plot.inner_width, plot.inner_height]
  if (!(width > 0 && height > 0)) { return }
  const extent = (values) => values.reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity])
  const [[left, right], [bottom, top]] = [extent(data.x), extent(data.y)]
  const whole = MARGIN * Math.max((right - left) / width, (top - bottom) / height)
  const ranges = [[plot.x_range, x0 + (left + right) / 2, width], [plot.y_range, y0 + (bottom + top) / 2, height]]
  for (const [range, at, pixels] of ranges) {
    range.setv({reset_start: at - (whole * pixels) / 2, reset_end: at + (whole * pixels) / 2})
  }
  const {x_range: x, y_range: y} = plot
  if (memory.whole === undefined || (x.start === memory.whole[0] && x.end === memory.whole[1])) {
    see(x0 + (left + right) / 2, y0 + (bottom + top) / 2, whole)
    memory.whole = [x.start, x.end]
  } else {
    see((x.start + x.end) / 2, (y.start + y.end) / 2, (x.end - x.start) / memory.width)
  }
  memory.width = width
}

function go_to_fallen() {
  const row = falls_source.selected.indices[0]
  if (row === undefined) { return }
  const block = falls_source.data.block[row]
  const [x] = motion_of(state)
  if (!Number.isFinite(x[block])) {
    const last = frames.findLastIndex((one) => Number.isFinite(motion_of(one)[0][block]))
    if (last >= 0) { frame.value = last }
  }
  choose("blocks", block)
  const [xs, ys] = outline(block, motion_of(frames[Math.round(frame.value)]))
  const near = (NEAR * Math.sqrt(data.area[block])) / Math.min(plot.inner_width, plot.inner_height)
  if (xs.length) { see(xs[0], ys[0], near) }
}

function draw() {
  find_again()
  draw_blocks()
  draw_joints()
  LINES.forEach(draw_lines)
  draw_marks()
  tell()
  const seen = shown.active.map((k) => shown.labels[k])
  for (const [kind, part] of Object.entries(parts)) {
    for (const glyphs of [part.glyphs, ...part.under]) { glyphs.visible = seen.includes(kind) }
    if ("bar" in part) { part.bar.visible = seen.includes(kind) && part.by.value !== "none" && (kind in state) }
  }
  plot.title.text = `${state.label}; ${times === 1 ? "true to scale" : `movements ${times} times`}`
  const here = String(Math.round(frame.value))
  stage.value = stage.options.some(([value]) => value === here) ? here : ""
  if (memory.drawn === undefined) {
    memory.drawn = true
    requestAnimationFrame(() => setTimeout(() => performance.mark("bsm-mesh drawn"))) // for who measures
  }
}

if (cb_obj === stage) {
  if (stage.value !== "") { frame.value = Number(stage.value) } // which calls this again
} else if (cb_obj === plot) {
  fit()
} else if (cb_obj === falls_source.selected) {
  go_to_fallen()
  draw_marks()
  tell()
} else if (cb_obj.event_name === "tap") {
  setTimeout(() => { // Bokeh selects first
    choose(...clicked())
    draw_marks()
    tell()
  })
} else {
  fit()
  draw()
}
