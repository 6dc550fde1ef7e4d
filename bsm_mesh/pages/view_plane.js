// Blocks in the plane, drawn by Bokeh; behind view.js. Given too: `plot`, and `down` and `chosen` (marks).

const [x0, y0] = data.middle
const LINES = ["bolts", "water"].filter((kind) => kind in parts)
const CLICKED = ["bolts", "joints", "blocks"].filter((kind) => kind in parts) // what lies above comes first
const MARGIN = 1.06 // of the model, round it
const SHADES = 32 // of joints
const AT_ONCE = 400 // joints: longer paths take more than their share of time
const STRIDE = 3 // both ends of a joint and the gap after it
const NEAR = 12 // sizes of a block that are seen when it is looked for

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
  const [cx, cy] = [data.centroid[0][block], data.centroid[1][block]]
  const [xs, ys] = [new Float64Array(last - first), new Float64Array(last - first)]
  for (let k = first; k < last; k++) {
    const [x, y] = [data.x[k], data.y[k]]
    const [dx, dy] = [x - cx, y - cy]
    xs[k - first] = x0 + x + times * (u + versed * dx - sine * dy)
    ys[k - first] = y0 + y + times * (v + sine * dx + versed * dy)
  }
  return [xs, ys]
}

function draw_blocks() {
  const count = data.bulk.length
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

function mark() {
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

function look_at(block) {
  const [xs, ys] = outline(block, motion_of(frames[Math.round(frame.value)]))
  const near = (NEAR * Math.sqrt(data.bulk[block])) / Math.min(plot.inner_width, plot.inner_height)
  if (xs.length) { see(xs[0], ys[0], near) }
}

function paint() {
  draw_blocks()
  draw_joints()
  LINES.forEach(draw_lines)
  const kinds = seen()
  for (const [kind, part] of Object.entries(parts)) {
    for (const glyphs of [part.glyphs, ...part.under]) { glyphs.visible = kinds.includes(kind) }
    if ("bar" in part) { part.bar.visible = kinds.includes(kind) && part.by.value !== "none" && (kind in state) }
  }
}

function entitle(text) {
  plot.title.text = text
}

if (cb_obj === plot) {
  fit()
} else if (cb_obj.event_name === "tap") {
  setTimeout(() => { // Bokeh selects first
    choose(...clicked())
    mark()
    tell()
  })
} else {
  fit()
  respond()
}
