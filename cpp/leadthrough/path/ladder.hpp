#pragma once

// A search over the task's redundancy in a ladder graph: the path of the tip is cut into layers,
// each layer holds collision-free configurations that meet the task, and the result is the cheapest
// path through all layers. Configurations out of reach of the previous layer are never examined.

#include <map>
#include <vector>

#include "leadthrough/collision/clearance.hpp"
#include "leadthrough/path/tip_task.hpp"

namespace leadthrough::path {

struct LadderOptions {
  IkTolerance tolerance{1e-5, 1e-5};
  double spacing = 0.025;          // m between layers at the most
  double rotation_spacing = 0.17;  // rad between layers at the most
  double cell = 0.15;      // configurations nearer than this to each other are one, rad or m
  double room = 0.0;       // m that configurations are farther away than their margins
  double longest = 0.5;    // that a joint moves from layer to layer, rad or m
  std::size_t width = 64;  // the most configurations that a layer hands on
  // If there are more: the cheapest of every branch, not of all.
  bool of_every_family = false;
};

// Sample at which no configuration is left. pairs: colliding pairs of shapes, with their counts.
struct DeadEnd {
  double sample = 0.0;
  std::map<std::size_t, int> pairs;
};

struct Climb {
  std::vector<double> samples;  // of the layers
  std::vector<JointArray> q;    // up to the last layer reached
  DeadEnd dead_end;             // of use where that is not the last of all

  bool arrived() const { return q.size() == samples.size(); }
};

// Samples at which a path is examined, possibly between two rows: evenly spaced along the tip's
// translation and rotation.
// spacing, rotation_spacing: how far the tip goes, m, and turns, rad, from one layer to the next at
// the most. The ends are among them.
std::vector<double> layers(const TipPath& path, double spacing, double rotation_spacing);

// postures: preferred configurations, one row per sample; not finite without a preference. start:
// the configuration at the first sample is as near to it as possible.
Climb climb(const Chain& chain, const TipPath& path, ClearanceTest& test, const RowsRef& postures,
            const std::optional<JointArray>& start, const LadderOptions& options);

}  // namespace leadthrough::path
