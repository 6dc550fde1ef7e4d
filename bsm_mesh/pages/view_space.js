// Polyhedra, drawn by Plotly; behind view.js. Given too: `opacity`, the slider of blocks that stay.
//
// `data.sides` has the sides of all blocks as given: `corners` from the model's middle, `offsets`, `block`, `other`.

const scene = document.getElementById("scene")
const SIDES = data.sides
const APART = 1e-3 // of the model's size: a side is seen where its two blocks have parted by more
const OUTSIDE = "outer faces" // of the body, in the list of what is shown
const MOST_NAMED = 40 // blocks: more names hide each other
const EDGE = "#4a4a4a", CHOSEN = "#ff00c8"
const AXES = {blocks: "coloraxis", joints: "coloraxis2", bolts: "coloraxis3"}
const NAMES = ["x (east), m", "y (north), m", "z (up), m"]

// ------------------------------------------------------------------------------------------------------- shapes

// Rotation less identity of a rotation vector, row after row: exact for large rotations (Rodrigues).
function turn_of(x, y, z) {
  const angle = Math.hypot(x, y, z)
  const [s, v] = angle > 0 ? [Math.sin(angle) / angle, 2 * (Math.sin(angle / 2) / angle) ** 2] : [1, 0.5]
  return [-v * (y * y + z * z), v * x * y - s * z, v * x * z + s * y,
    v * x * y + s * z, -v * (x * x + z * z), v * y * z - s * x,
    v * x * z - s * y, v * y * z + s * x, -v * (x * x + y * y)]
}

// Movements of all blocks that are there; undefined for others.
function movements() {
  const motion = motion_of(state)
  return Array.from(data.bulk, (_, b) => {
    if (!Number.isFinite(motion[0][b])) { return undefined }
    const [u, v, w, x, y, z] = motion.map((values) => values[b])
    return [u, v, w, ...turn_of(x, y, z)]
  })
}

// Where the corner `k` of a side is with a block, from the model's middle.
function corner(k, b, moved) {
  const m = moved[b]
  const [x, y, z] = [SIDES.corners[3 * k], SIDES.corners[3 * k + 1], SIDES.corners[3 * k + 2]]
  const [dx, dy, dz] = [x - data.centroid[0][b], y - data.centroid[1][b], z - data.centroid[2][b]]
  return [x + times * (m[0] + m[3] * dx + m[4] * dy + m[5] * dz),
    y + times * (m[1] + m[6] * dx + m[7] * dy + m[8] * dz),
    z + times * (m[2] + m[9] * dx + m[10] * dy + m[11] * dz)]
}

// The sides that are bare: of blocks that are there, with nothing beyond, or from which the block beyond has parted.
function bare_sides(moved) {
  const outside = seen().includes(OUTSIDE)
  const found = []
  for (let s = 0; s < SIDES.block.length; s++) {
    const [a, b] = [SIDES.block[s], SIDES.other[s]]
    if (moved[a] === undefined || (b < 0 && !outside)) { continue }
    if (b < 0 || moved[b] === undefined) { found.push(s); continue }
    const [p, q] = [a, b].map((block) => corner(SIDES.offsets[s], block, moved))
    if (Math.hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]) > APART * data.span) { found.push(s) }
  }
  return found
}

function polygons_of_sides(sides, moved) {
  return sides.map((s) => {
    const points = []
    for (let k = SIDES.offsets[s]; k < SIDES.offsets[s + 1]; k++) { points.push(corner(k, SIDES.block[s], moved)) }
    return points
  })
}

function polygons_of(kind) {
  const {ends, moved, offsets} = state[kind]
  return Array.from({length: offsets.length - 1}, (_, k) => {
    const points = []
    for (let p = offsets[k]; p < offsets[k + 1]; p++) {
      points.push([0, 1, 2].map((c) => ends[3 * p + c] + times * moved[3 * p + c]))
    }
    return points
  })
}

// -------------------------------------------------------------------------------------------------------- traces

function columns(points) {
  const of = (c) => Float64Array.from(points, (point) => (point === null ? NaN : point[c] + data.middle[c]))
  return {x: of(0), y: of(1), z: of(2)}
}

// Convex polygons as triangles; `owner` is the block or joint of each, `values` what it is coloured by.
function mesh(kind, polygons, owner, values, look) {
  const triangles = {i: [], j: [], k: []}
  const [intensity, of_point, points] = [[], [], []]
  polygons.forEach((polygon, n) => {
    const first = points.length
    for (const point of polygon) { points.push(point); of_point.push(owner[n]) }
    for (let c = 1; c + 1 < polygon.length; c++) {
      triangles.i.push(first)
      triangles.j.push(first + c)
      triangles.k.push(first + c + 1)
      intensity.push(values[n])
    }
  })
  const name = parts[kind].by.value
  const text = of_point.map((k) => `${kind.slice(0, -1)} ${kind === "joints" ? "" : k}<br>${name in state[kind].arrays ? `${name}: ${value_text(kind, name, state[kind].arrays[name][k])}` : ""}`)
  return {type: "mesh3d", ...columns(points), ...triangles, intensity, intensitymode: "cell", coloraxis: AXES[kind],
    flatshading: true, hoverinfo: "text", text, meta: {kind, owner: of_point}, name: kind,
    lighting: {ambient: 0.6, diffuse: 0.5, specular: 0.05}, ...look}
}

function lines(polygons, look) {
  const points = polygons.flatMap((polygon) => [...polygon, polygon[0], null])
  return {type: "scatter3d", mode: "lines", ...columns(points), hoverinfo: "skip", ...look}
}

function values_of(kind) {
  const {by} = scale_of(kind, parts[kind].by.value)
  const values = state[kind].arrays[parts[kind].by.value]
  return (k) => (values === undefined ? 0 : values[k] / by)
}

function block_traces(moved) {
  const [sides, down] = [bare_sides(moved), new Set(state.unstable)]
  const value = values_of("blocks")
  const found = []
  for (const [name, falls] of [["stays", false], ["falls", true]]) {
    const some = sides.filter((s) => down.has(SIDES.block[s]) === falls)
    const polygons = polygons_of_sides(some, moved)
    const owner = some.map((s) => SIDES.block[s])
    found.push({...mesh("blocks", polygons, owner, owner.map(value), {opacity: falls ? 1 : opacity.value}), name})
    found.push(lines(polygons, {line: falls ? {color: data.falls, width: 5} : {color: EDGE, width: 1.5}, opacity: falls || opacity.value === 1 ? 1 : 0.6}))
  }
  return found
}

function joint_traces() {
  const polygons = polygons_of("joints")
  const owner = polygons.map((_, k) => k)
  return [mesh("joints", polygons, owner, owner.map(values_of("joints")), {}), lines(polygons, {line: {color: EDGE, width: 1}})]
}

function bolt_traces() {
  const polygons = polygons_of("bolts")
  const value = values_of("bolts")
  const points = polygons.flatMap((polygon) => [...polygon, null])
  const owner = polygons.flatMap((polygon, k) => [...polygon.map(() => k), k])
  const look = {color: owner.map(value), coloraxis: AXES.bolts, width: 9}
  return [{type: "scatter3d", mode: "lines", ...columns(points), line: look, meta: {kind: "bolts", owner}, name: "bolts",
    text: owner.map((k) => `bolt ${escaped(data.bolt_names[state.bolts.which[2 * k]])}`), hoverinfo: "text"}]
}

function label_trace(moved) {
  const there = Array.from(state.unstable).filter((b) => moved[b] !== undefined).slice(0, MOST_NAMED)
  const points = there.map((b) => data.centroid.map((values, c) => values[b] + times * moved[b][c]))
  return {type: "scatter3d", mode: "text", ...columns(points), text: there.map(String), hoverinfo: "skip",
    textfont: {color: data.falls, size: 15}}
}

function chosen_trace(moved) {
  const one = memory.chosen
  let polygons = []
  if (one?.kind === "blocks" && moved[one.index] !== undefined) {
    const sides = Array.from(SIDES.block.keys()).filter((s) => SIDES.block[s] === one.index)
    polygons = polygons_of_sides(sides, moved)
  } else if (one !== undefined && one.kind !== "blocks" && one.index >= 0 && one.kind in state) {
    polygons = [polygons_of(one.kind)[one.index]]
  }
  return lines(polygons, {line: {color: CHOSEN, width: 8}, name: "chosen"})
}

// A scale of colours; the n-th of those that are shown.
function colour_axis(kind, n) {
  const {palette, low, high, title, names} = scale_of(kind, parts[kind].by.value)
  const last = palette.length - (names.length ? 0 : 1)
  const steps = names.length ? palette.flatMap((colour, k) => [[k / last, colour], [(k + 1) / last, colour]])
    : palette.map((colour, k) => [last ? k / last : 0, colour])
  const ticks = names.length ? names.map((_, k) => k) : round_numbers(low, high)
  return {cmin: low, cmax: high, colorscale: steps.length > 1 ? steps : [[0, palette[0]], [1, palette[0]]], showscale: title !== "",
    colorbar: {title: {text: escaped(title), side: "right"}, x: 1 + 0.09 * n, thickness: 12, len: 0.8, tickvals: ticks,
      ticktext: names.length ? names.map(escaped) : ticks.map(String)}}
}

// --------------------------------------------------------------------------------------------------- what is seen

function show() {
  const kinds = seen().filter((kind) => kind in parts && kind in state)
  const moved = movements()
  const traces = kinds.flatMap((kind) => (kind === "blocks" ? block_traces(moved) : kind === "joints" ? joint_traces() : bolt_traces()))
  const bars = kinds.filter((kind) => parts[kind].by.value !== "none")
  const axes = Object.fromEntries(kinds.map((kind) => [AXES[kind], colour_axis(kind, Math.max(bars.indexOf(kind), 0))]))
  const layout = {
    title: {text: escaped(memory.title), font: {size: 15}}, margin: {l: 0, r: 0, t: 40, b: 0}, showlegend: false,
    uirevision: "same", ...axes,
    scene: {
      aspectmode: "data", camera: {eye: data.eye, up: {x: 0, y: 0, z: 1}, projection: {type: "orthographic"}},
      ...Object.fromEntries(NAMES.map((text, c) => [`${"xyz"[c]}axis`, {title: {text}}])),
    },
  }
  const marks = kinds.includes("blocks") ? [label_trace(moved)] : []
  Plotly.react(scene, [...traces, ...marks, chosen_trace(moved)], layout, {responsive: true, displaylogo: false})
  scene.removeAllListeners("plotly_click")
  scene.on("plotly_click", ({points: [point]}) => {
    const meta = point.data.meta
    if (meta === undefined) { return }
    choose(meta.kind, meta.owner[point.pointNumber])
    show()
    tell()
  })
}

function paint() {} // all is shown at once, behind the marks

function mark() {
  show()
}

function look_at() {} // the block is marked

function entitle(text) {
  memory.title = text
}

respond()
