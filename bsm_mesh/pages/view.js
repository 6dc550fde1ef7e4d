// Shows a state of the results: the common part of the pages of the plane (view_plane.js) and of space (view_space.js).
//
// Bokeh calls this for every change of a widget, every click and every size of the plot.
// Given by Python: `data` (numbers), `parts` (what is drawn of each kind), `memory` (stays between calls), the widgets
// `frame`, `stage`, `factor`, `shown`, `told`, and `falls_source`. Dictionaries of Python are objects here, arrays are
// typed arrays. A page draws with `paint` (a state), `mark` (unstable and chosen things), `look_at` (a block) and
// `entitle`.
"use strict"

const frames = data.frames
const state = frames[Math.round(frame.value)]
const times = Number(factor.value)
const ROUNDING = 1e-9 // of the greatest value: less is told as 0
const SQUARED = ["", "m2", "m3"] // units without a prefix
const PREFIXES = [[1e9, 1e9, "G"], [1e6, 1e6, "M"], [1e3, 1e3, "k"], [1, 1, ""], [1e-6, 1e-3, "m"], [0, 1e-6, "u"]]

// ------------------------------------------------------------------------------------------------------- texts

function escaped(text) {
  return String(text).replace(/[&<>"']/g, (c) => `&#${c.charCodeAt(0)};`)
}

function prefix(value, unit) {
  const [, by, letter] = SQUARED.includes(unit) || value === 0 ? [1, 1, ""] : PREFIXES.find(([least]) => Math.abs(value) >= least)
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

// ------------------------------------------------------------------------------------------------ what is chosen

function motion_of(one) {
  return data.motion.map((name) => one.blocks.arrays[name])
}

function is_there(one, block) {
  return Number.isFinite(motion_of(one)[0][block])
}

// Where a joint is: the sum of the points of its line or polygon.
function place_of(layer, k) {
  const d = data.middle.length
  const [first, last] = layer.offsets.length ? [layer.offsets[k], layer.offsets[k + 1]] : [2 * k, 2 * k + 2]
  const sum = new Array(d).fill(0)
  for (let point = first; point < last; point++) {
    for (let c = 0; c < d; c++) { sum[c] += layer.ends[d * point + c] / (last - first) }
  }
  return sum
}

function choose(kind, index) {
  if (kind === undefined) { memory.chosen = undefined; return }
  const one = {kind, index}
  if (kind === "joints") {
    const layer = state[kind]
    one.blocks = [layer.which[2 * index], layer.which[2 * index + 1]]
    one.place = place_of(layer, index)
  }
  memory.chosen = one
}

// The face of the same blocks that is nearest, where a state has other faces; none: -1.
function find_again() {
  const one = memory.chosen
  if (one?.kind !== "joints") { return }
  const which = state.joints.which
  const [a, b] = one.blocks
  let nearest = Infinity
  one.index = -1
  for (let k = 0; 2 * k < which.length; k++) {
    const [c, d] = [which[2 * k], which[2 * k + 1]]
    if (!((a === c && b === d) || (a === d && b === c))) { continue }
    const far = Math.hypot(...place_of(state.joints, k).map((value, i) => value - one.place[i]))
    if (far < nearest) { [nearest, one.index] = [far, k] }
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
    const at = data.centroid.map((values, c) => (values[index] + data.middle[c]).toFixed(3))
    rows.push([data.bulk_name, engineering(data.bulk[index], data.bulk_unit)], ["given at", `(${at.join(", ")}) m`])
  } else if (kind === "joints") {
    name = `Joint between blocks ${one.blocks[0]} and ${one.blocks[1]}`
  } else if ("bolts" in state) {
    name = `Bolt ${data.bolt_names[state.bolts.which[2 * index]]}`
  }
  const arrays = index < 0 ? undefined : state[kind]?.arrays
  const there = arrays !== undefined && (kind !== "blocks" || is_there(state, index))
  const others = there ? Object.entries(arrays).filter(([array]) => array !== data.bulk_name) : [] // which is told above
  for (const [array, values] of others) { rows.push([array, value_text(kind, array, values[index])]) }
  const table = rows.map((cells) => `<tr>${cells.map((cell) => `<td>${escaped(cell)}</td>`).join("")}</tr>`).join("")
  told.text = `<b>${escaped(name || "Bolt")}</b>${there ? "" : " is not there in this state"}<table>${table}</table>`
}

// -------------------------------------------------------------------------------------------------- what is seen

function seen() {
  return shown.active.map((k) => shown.labels[k])
}

function go_to_fallen() {
  const row = falls_source.selected.indices[0]
  if (row === undefined) { return }
  const block = falls_source.data.block[row]
  if (!is_there(state, block)) {
    const last = frames.findLastIndex((one) => is_there(one, block))
    if (last >= 0) { frame.value = last }
  }
  choose("blocks", block)
  look_at(block)
}

function draw() {
  find_again()
  entitle(`${state.label}; ${times === 1 ? "true to scale" : `movements ${times} times`}`)
  paint()
  mark()
  tell()
  const here = String(Math.round(frame.value))
  stage.value = stage.options.some(([value]) => value === here) ? here : ""
  if (memory.drawn === undefined) {
    memory.drawn = true
    requestAnimationFrame(() => setTimeout(() => performance.mark("bsm-mesh drawn"))) // for who measures
  }
}

function respond() {
  if (cb_obj === stage) {
    if (stage.value !== "") { frame.value = Number(stage.value) } // which calls this again
  } else if (cb_obj === falls_source.selected) {
    go_to_fallen()
    mark()
    tell()
  } else {
    draw()
  }
}

