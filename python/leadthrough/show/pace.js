// How well a scene is drawn while it moves, so that 60 frames come in a second: times from frame to
// frame go in, a way of drawing comes out. No clock and no browser.

// Most pixels for one of the page, texels of the shadow's edge (-1: no shadow), samples for a pixel.
// The first way draws what stands still, and what moves where that is quick enough.
const WAYS = [
  { ratio: 2, blur: 2, samples: 4 }, { ratio: 1, blur: 1, samples: 1 },
  { ratio: 1, blur: -1, samples: 1 }, { ratio: 0.8, blur: -1, samples: 1 },
  { ratio: 0.66, blur: -1, samples: 1 }, { ratio: 0.5, blur: -1, samples: 1 },
  { ratio: 0.4, blur: -1, samples: 1 },
];
const BY_PROCESSOR = 4; // the way to begin with where no graphics card draws

const FRAME = 1000 / 60; // ms
const DUE = 1.05 * FRAME; // ms; a frame that takes longer is late
const MOST = 6 * FRAME; // ms for which one frame counts at most: a single stall is forgiven
const OWED = 110; // ms late in all after which frames are drawn in a quicker way
const OWED_BY_TRY = 40; // ms; the same for a way that is only tried
const HELPS = 0.9; // of the time that a frame took before
const PATIENCE = [4000, 64000]; // ms in time before a finer way is tried, after few failures and many
const LEFT = 300000; // ms without another try where no way was any quicker
const ABSENT = 5000; // ms; a longer one is no frame but a window that was out of sight

// The pace of a scene that is drawn in this way from now on.
function begun(way, { patience = PATIENCE[0], from = null, tried = false } = {}) {
  return { way, patience, from, tried, owed: 0, time: 0, mean: 0, left: 0 };
}

// The pace after one more frame, so many ms after the frame before.
function paced(pace, interval) {
  if (!(interval > 0 && interval < ABSENT)) return pace;
  if (pace.left > 0) return { ...pace, left: pace.left - interval };
  const owed = Math.max(0, pace.owed + Math.min(interval, MOST) - DUE);
  const mean = pace.time ? 0.8 * pace.mean + 0.2 * interval : interval;
  const next = { ...pace, owed, mean, time: pace.time + interval };
  if (owed > (pace.tried ? OWED_BY_TRY : OWED)) return quicker(next);
  return next.way > 0 && next.time > next.patience && owed < FRAME ? finer(next) : next;
}

// Tries a finer way. A way that fails is tried again after twice the time.
function finer({ way, patience }) { return begun(way - 1, { patience, tried: true }); }

function quicker({ way, patience, from, tried, time, mean }) {
  const failed = tried && time < patience;
  const next = { patience: failed ? Math.min(2 * patience, PATIENCE[1]) : PATIENCE[0] };
  if (failed) return begun(way + 1, next);
  const first = from || { way, mean };
  if (way < WAYS.length - 1) return begun(way + 1, { ...next, from: first });
  const helped = mean < HELPS * first.mean || first.way === way;
  return helped ? begun(way, { ...next, from: first }) : { ...begun(first.way), left: LEFT };
}
