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
const EVEN = 0.1; // of the time that frames take, by which they differ
const PATIENCE = [4000, 64000]; // ms in time before a finer way is tried, after few failures and many
const SURE = 1000; // ms drawn in the quickest way before it is said that it is no quicker
const LEFT = 20000; // ms in full after no way was quicker; twice as many each time
const ABSENT = 5000; // ms; a longer one is no frame but a window that was out of sight

// The pace of a scene that is drawn in this way from now on.
function begun(way, { patience = PATIENCE[0], vain = 0, from = null, tried = false } = {}) {
  return { way, patience, vain, from, tried, owed: 0, time: 0, mean: 0, spread: 0, left: 0 };
}

// The pace after one more frame, so many ms after the frame before.
function paced(pace, interval) {
  if (!(interval > 0 && interval < ABSENT)) return pace;
  if (pace.left > 0) return { ...pace, left: pace.left - interval };
  const way = pace.way, owed = Math.max(0, pace.owed + Math.min(interval, MOST) - DUE);
  const mean = pace.time ? 0.8 * pace.mean + 0.2 * interval : interval;
  const spread = 0.8 * pace.spread + 0.2 * Math.abs(interval - mean);
  const next = { ...pace, owed, mean, spread, time: pace.time + interval };
  const proven = next.time > next.patience, most = pace.tried && !proven ? OWED_BY_TRY : OWED;
  if (owed > most) return way < WAYS.length - 1 ? quicker(next) : quickest(next);
  return way > 0 && proven && owed < FRAME ? finer(next) : next;
}

// Tries a finer way. One that fails is tried again after twice the time.
function finer({ way, patience }) { return begun(way - 1, { patience, tried: true }); }

function quicker({ way, patience, vain, from, tried, time, mean }) {
  if (tried && time < patience) return begun(way + 1, { patience: Math.min(2 * patience, PATIENCE[1]) });
  return begun(way + 1, { vain, from: from || { way, mean } });
}

// Stays with the quickest way, unless frames come as slowly as at first and evenly: a screen may show
// 30 of them in a second, where a machine that is too slow shows some late and some in time.
function quickest(pace) {
  const { from, time, mean, spread, vain } = pace;
  const vainly = from && time > SURE && mean > HELPS * from.mean && spread < EVEN * mean;
  if (!vainly) return { ...pace, owed: 0 };
  return { ...begun(from.way, { vain: Math.min(vain + 1, 6) }), left: LEFT * 2 ** vain };
}
