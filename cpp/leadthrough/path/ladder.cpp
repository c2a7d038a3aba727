#include "leadthrough/path/ladder.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <unordered_map>
#include <unordered_set>

#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/ik/joint_ranges.hpp"

namespace leadthrough::path {

namespace {

// Costs, in squared radians of a step from one layer to the next.
constexpr double kAwayFromPosture = 2e-3;  // a squared radian
constexpr double kAwayFromStart = 1.0;     // at the first layer
constexpr double kAwayFromPath = 0.02;     // on the surface of the tube
constexpr double kBesideObstacle = 0.02;
constexpr double kBesideLimit = 0.02;
constexpr double kRoom = 0.02;        // m, preferred distance of obstacles beyond the margin
constexpr double kLimitZone = 0.1;    // rad or m before a limit
constexpr double kStride = 1.6;       // cells, length of a step along a free direction
constexpr double kAside = 0.5;        // of a tube's radius, length of a step in it
constexpr double kSurface = 0.95;     // of a tube's radius, end of a step that would leave it
constexpr double kFamily = 0.8;       // rad or m: cell size of a branch of configurations
constexpr std::size_t kFew = 12;      // configurations of a layer
constexpr double kFinestCell = 0.01;  // rad or m
constexpr int kRestarts = 100;        // of inverse kinematics at the first layer
constexpr int kRestartSteps = 40;
constexpr double kMaxLayers = 1e4;
constexpr int kMaxRepairs = 400;  // of routes whose configurations do not connect

// Numbers for the cubes of cells that configurations lie in (FNV-1a over whole coordinates).
std::uint64_t mixed(std::uint64_t hash, long value) {
  return (hash ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(value))) * 0x100000001b3U;
}

// The cell of a configuration, of a size in rad or m; full revolutions are ignored.
std::uint64_t cell_of(const Chain& chain, const JointArray& q, double size) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (std::size_t i = 0; i < static_cast<std::size_t>(chain.joints()); ++i) {
    const double value = chain.periodic[i] ? std::remainder(q[i], kTurn) : q[i];
    hash = mixed(hash, std::lround(value / size));
  }
  return hash;
}

// Motion of the tip between two rows, in layers.
double steps_between(const TipPath& path, Eigen::Index row, double spacing,
                     double rotation_spacing) {
  const double distance = (path.positions.row(row + 1) - path.positions.row(row)).norm();
  double rotation = 0.0;
  if (path.orientations.rows() > 0) {
    const double cosine = std::abs(path.orientations.row(row).dot(path.orientations.row(row + 1)));
    rotation = 2.0 * std::acos(std::min(cosine, 1.0));
  }
  return distance / spacing + rotation / rotation_spacing;
}

struct Node {
  JointArray q;
  double own = 0.0;
  double cost = kInfinity;
  int parent = -1;
};

struct Layer {
  double sample;
  TipTask task;
  JointArray posture;
  std::vector<Node> nodes;
};

using Edge = std::array<int, 3>;  // layer, parent, child

class Ladder {
 public:
  Ladder(const Chain& chain, const TipPath& path, ClearanceTest& test, const RowsRef& postures,
         const std::optional<JointArray>& start, const LadderOptions& options)
      : chain_(chain),
        path_(path),
        test_(test),
        start_(start),
        options_(options),
        n_(index(chain.joints())),
        limits_(position_limits(chain)) {
    for (const double sample : layers(path, options.spacing, options.rotation_spacing))
      layers_.push_back({sample, TipTask(chain, path, sample), posture_at(postures, sample), {}});
  }

  Climb run() {
    Climb result;
    for (const Layer& layer : layers_) result.samples.push_back(layer.sample);
    std::size_t reached = 0;
    for (; reached < layers_.size(); ++reached) {
      check_interrupt();
      reached == 0 ? begin() : advance(reached);
      if (layers_[reached].nodes.empty()) break;
    }
    if (reached == layers_.size()) reached = connect();
    if (reached < layers_.size()) {
      dead_end_.sample = layers_[reached].sample;
      result.dead_end = dead_end_;
    }
    result.q = route(reached);
    return result;
  }

 private:
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }

  static JointArray posture_at(const RowsRef& postures, double sample) {
    const Eigen::Index last = postures.rows() - 1;
    const auto row = std::min(static_cast<Eigen::Index>(sample), last);
    const Eigen::Index next = std::min(row + 1, last);
    const double share = sample - static_cast<double>(row);
    JointArray posture{};
    for (Eigen::Index i = 0; i < postures.cols(); ++i)
      posture[static_cast<std::size_t>(i)] =
          (1.0 - share) * postures(row, i) + share * postures(next, i);
    return posture;
  }

  void begin() {
    Layer& layer = layers_.front();
    clear_cells();
    JointArray reference{};
    const JointVector middle = leadthrough::middle(chain_);
    for (std::size_t i = 0; i < n_; ++i) {
      reference[i] = middle[static_cast<Eigen::Index>(i)];
      if (std::isfinite(layer.posture[i])) reference[i] = layer.posture[i];
      if (start_) reference[i] = (*start_)[i];
      reference[i] = std::clamp(reference[i], limits_.lower[i], limits_.upper[i]);
    }
    std::vector<JointArray> open;
    for (int i = 0; i < kRestarts; ++i) {
      check_interrupt();
      RandomStream random(0, static_cast<std::uint64_t>(i));
      JointArray q = i == 0 ? reference : random_configuration(chain_, random);
      if (!layer.task.settle_at({}, limits_, options_.tolerance, q, kRestartSteps)) continue;
      if (cells_.count(cell(layer.task, q)) > 0) continue;
      open.push_back(q);
      offer(0, q);
    }
    // The first layer is explored through obstacles too: free space behind them is not known yet.
    const std::size_t most = 8 * options_.width;
    for (std::size_t i = 0; i < open.size() && open.size() < most; ++i)
      walk(layer.task, JointArray(open[i]), [&](const JointArray& q) {
        check_interrupt();
        open.push_back(q);
        offer(0, q);
      });
    narrow(layer);
  }

  void advance(std::size_t k) {
    Layer& layer = layers_[k];
    clear_cells();
    open_.clear();
    cell_ = options_.cell;
    for (const Node& from : layers_[k - 1].nodes) {
      check_interrupt();
      JointArray q = from.q;
      if (layer.task.settle(near(q), options_.tolerance, q) && offer(k, q)) open_.push_back(q);
      if (!layer.task.tube()) continue;
      q = from.q;  // back onto the path
      if (layer.task.settle_at({}, near(q), options_.tolerance, q) && offer(k, q))
        open_.push_back(q);
    }
    // Narrow places are examined in finer cells.
    fill(k);
    while (layer.nodes.size() < kFew && cell_ > kFinestCell) {
      cell_ *= 0.5;
      cells_.clear();
      for (const JointArray& q : open_) cells_.insert(cell(layer.task, q));
      fill(k);
    }
    narrow(layer);
  }

  // The limits, narrowed to a joint's largest motion from one layer to the next.
  JointBox near(const JointArray& q) const {
    return around(q, options_.longest, limits_, chain_.joints());
  }

  // Explores a layer from every configuration along the task's null space, through obstacles too:
  // configurations behind them may be in reach of the layer before.
  void fill(std::size_t k) {
    Layer& layer = layers_[k];
    std::vector<JointArray>& open = open_;
    const std::size_t most = open.size() + 4 * options_.width;
    for (std::size_t i = 0; i < open.size() && open.size() < most; ++i)
      walk(layer.task, JointArray(open[i]), [&](const JointArray& q) {
        check_interrupt();
        if (offer(k, q)) open.push_back(q);
      });
  }

  // Calls found(q) for the unvisited configurations a cell away.
  template <typename Found>
  void walk(const TipTask& task, const JointArray& from, Found found) {
    const FreeDirections free = task.free_directions(from);
    for (int d = 0; d < free.count; ++d) {
      const JointArray& direction = free.directions[index(d)];
      for (const double step : {kStride * cell_, -kStride * cell_}) {
        JointArray q = from;
        for (std::size_t j = 0; j < n_; ++j)
          q[j] = std::clamp(q[j] + step * direction[j], limits_.lower[j], limits_.upper[j]);
        if (cells_.count(cell(task, q)) > 0) continue;
        if (task.settle(near(from), options_.tolerance, q) && cells_.count(cell(task, q)) == 0)
          found(q);
      }
    }
    if (task.tube()) walk_in_tube(task, from, found);
  }

  // The same for positions in the tube, on both sides along each of its axes.
  template <typename Found>
  void walk_in_tube(const TipTask& task, const JointArray& from, Found found) {
    const TubePlace here = task.place(from);
    for (int k = 0; k < here.size(); ++k) {
      for (const double step : {kAside, -kAside}) {
        TubePlace place = here;
        place[k] += step;
        if (place.norm() > 1.0) place *= kSurface / place.norm();
        JointArray q = from;
        if (task.settle_at(place, near(from), options_.tolerance, q) &&
            cells_.count(cell(task, q)) == 0)
          found(q);
      }
    }
  }

  // Adds a configuration that is clear, new and in reach; false if it is not new or out of
  // reach.
  bool offer(std::size_t k, const JointArray& q) {
    if (!cells_.insert(cell(layers_[k].task, q)).second) return false;
    constexpr int kNew = -1;
    Node node{q, 0.0, 0.0, -1};
    if (k > 0 && !adopt(k, kNew, node)) return false;
    if (!test_.clear(q.data(), -options_.room)) {
      ++dead_end_.pairs[test_.blocker()];
      return true;
    }
    node.own = own_cost(k, q);
    node.cost += node.own;
    layers_[k].nodes.push_back(node);
    return true;
  }

  // Sets the cheapest parent of a node of layer k; false if none is within reach.
  bool adopt(std::size_t k, int child, Node& node) const {
    const std::vector<Node>& parents = layers_[k - 1].nodes;
    node.cost = kInfinity;
    node.parent = -1;
    for (std::size_t a = 0; a < parents.size(); ++a) {
      check_interrupt();
      double squared = 0.0, most = 0.0;
      for (std::size_t i = 0; i < n_; ++i) {
        const double step = std::abs(node.q[i] - parents[a].q[i]);
        squared += step * step;
        most = std::max(most, step);
      }
      const double cost = parents[a].cost + squared + node.own;
      if (most > options_.longest || cost >= node.cost) continue;
      const int parent = static_cast<int>(a);
      if (refused_.count({static_cast<int>(k), parent, child}) > 0) continue;
      node.cost = cost;
      node.parent = parent;
    }
    return node.parent >= 0;
  }

  double own_cost(std::size_t k, const JointArray& q) {
    double cost = test_.clear(q.data(), -kRoom) ? 0.0 : kBesideObstacle;
    if (layers_[k].task.tube()) cost += kAwayFromPath * layers_[k].task.place(q).squaredNorm();
    for (std::size_t i = 0; i < n_; ++i) {
      const double away = q[i] - layers_[k].posture[i];
      if (std::isfinite(away)) cost += kAwayFromPosture * away * away;
      if (k == 0 && start_) cost += kAwayFromStart * std::pow(q[i] - (*start_)[i], 2);
      const double room = std::min(q[i] - limits_.lower[i], limits_.upper[i] - q[i]);
      if (room < kLimitZone) cost += kBesideLimit * (1.0 - room / kLimitZone);
    }
    return cost;
  }

  // Keeps the cheapest.
  void narrow(Layer& layer) const {
    std::stable_sort(layer.nodes.begin(), layer.nodes.end(),
                     [](const Node& a, const Node& b) { return a.cost < b.cost; });
    const std::size_t most = (&layer == layers_.data() ? 4 : 1) * options_.width;
    if (layer.nodes.size() <= most) return;
    if (options_.of_every_family) take_turns(layer.nodes);
    layer.nodes.resize(most);
  }

  // First the cheapest of every branch, then the second of every branch, and so on.
  void take_turns(std::vector<Node>& nodes) const {
    std::unordered_map<std::uint64_t, int> counts;
    std::vector<std::pair<int, Node>> ranked;
    for (const Node& node : nodes)
      ranked.emplace_back(counts[cell_of(chain_, node.q, kFamily)]++, node);
    std::stable_sort(ranked.begin(), ranked.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::transform(ranked.begin(), ranked.end(), nodes.begin(),
                   [](const auto& each) { return each.second; });
  }

  // Verifies the cheapest route between its layers too; if it fails, takes the next one. Returns
  // the first layer out of reach of verified routes, or the number of layers.
  std::size_t connect() {
    for (int repair = 0; repair < kMaxRepairs; ++repair) {
      const std::vector<int> chosen = chosen_nodes(layers_.size() - 1);
      std::size_t k = 1;
      while (k < layers_.size() && holds(k, chosen[k - 1], chosen[k])) ++k;
      if (k == layers_.size()) return k;
      refused_.insert({static_cast<int>(k), chosen[k - 1], chosen[k]});
      for (std::size_t l = k; l < layers_.size(); ++l)
        if (!relax(l)) return l;
    }
    return layers_.size() - 1;
  }

  // Recomputes the cost of each node of a layer; false if no route leads to any of them.
  bool relax(std::size_t k) {
    bool any = false;
    for (std::size_t b = 0; b < layers_[k].nodes.size(); ++b) {
      check_interrupt();
      any = adopt(k, static_cast<int>(b), layers_[k].nodes[b]) || any;
    }
    return any;
  }

  // True if the arm stays on the path, on its branch of postures and collision-free from one layer
  // to the next.
  bool holds(std::size_t k, int parent, int child) {
    if (held_.count({static_cast<int>(k), parent, child}) > 0) return true;
    const JointArray& a = layers_[k - 1].nodes[index(parent)].q;
    const JointArray& b = layers_[k].nodes[index(child)].q;
    constexpr int kParts = 4;
    constexpr double kMaxDeviation = 0.25;  // rad or m, of a joint from the straight line
    const double from = layers_[k - 1].sample;
    for (int part = 1; part < kParts; ++part) {
      check_interrupt();
      const double share = static_cast<double>(part) / kParts;
      JointArray q{};
      for (std::size_t i = 0; i < n_; ++i) q[i] = (1.0 - share) * a[i] + share * b[i];
      const JointBox bounds = around(q, kMaxDeviation, limits_, chain_.joints());
      const TipTask task(chain_, path_, from + share * (layers_[k].sample - from));
      if (!task.settle(bounds, options_.tolerance, q) || !test_.clear(q.data(), kRoom))
        return false;
    }
    held_.insert({static_cast<int>(k), parent, child});
    return true;
  }

  std::vector<int> chosen_nodes(std::size_t last) const {
    std::vector<int> chosen(last + 1);
    const std::vector<Node>& ends = layers_[last].nodes;
    const auto cheaper = [](const Node& a, const Node& b) { return a.cost < b.cost; };
    chosen[last] =
        static_cast<int>(std::min_element(ends.begin(), ends.end(), cheaper) - ends.begin());
    for (std::size_t k = last; k > 0; --k)
      chosen[k - 1] = layers_[k].nodes[index(chosen[k])].parent;
    return chosen;
  }

  // The configurations of the cheapest route through the first `count` layers.
  std::vector<JointArray> route(std::size_t count) const {
    std::vector<JointArray> q;
    if (count == 0) return q;
    const std::vector<int> chosen = chosen_nodes(count - 1);
    for (std::size_t k = 0; k < count; ++k) q.push_back(layers_[k].nodes[index(chosen[k])].q);
    return q;
  }

  void clear_cells() {
    cells_.clear();
    dead_end_ = {};
  }

  // In a tube, positions far from each other have different cells.
  std::uint64_t cell(const TipTask& task, const JointArray& q) const {
    std::uint64_t hash = cell_of(chain_, q, cell_);
    if (!task.tube()) return hash;
    for (const double along : task.place(q)) hash = mixed(hash, std::lround(along / kAside));
    return hash;
  }

  const Chain& chain_;
  const TipPath& path_;
  ClearanceTest& test_;
  const std::optional<JointArray>& start_;
  const LadderOptions& options_;
  std::size_t n_;
  JointBox limits_;
  std::vector<Layer> layers_;
  std::unordered_set<std::uint64_t> cells_;
  double cell_ = options_.cell;
  std::vector<JointArray> open_;  // configurations of the layer to explore from
  std::set<Edge> refused_, held_;
  DeadEnd dead_end_;
};

}  // namespace

std::vector<double> layers(const TipPath& path, double spacing, double rotation_spacing) {
  const Eigen::Index rows = path.positions.rows();
  std::vector<double> along(static_cast<std::size_t>(rows), 0.0);
  for (std::size_t i = 1; i < along.size(); ++i)
    along[i] = along[i - 1] +
               steps_between(path, static_cast<Eigen::Index>(i) - 1, spacing, rotation_spacing);
  const double steps = along.back() > 1.0 ? std::min(along.back(), kMaxLayers) : 1.0;
  const auto parts = static_cast<std::size_t>(std::ceil(steps));
  std::vector<double> samples{0.0};
  std::size_t row = 0;
  for (std::size_t k = 1; k < parts; ++k) {
    const double at = along.back() * static_cast<double>(k) / static_cast<double>(parts);
    while (along[row + 1] < at) ++row;
    samples.push_back(static_cast<double>(row) + (at - along[row]) / (along[row + 1] - along[row]));
  }
  if (rows > 1) samples.push_back(static_cast<double>(rows - 1));
  return samples;
}

Climb climb(const Chain& chain, const TipPath& path, ClearanceTest& test, const RowsRef& postures,
            const std::optional<JointArray>& start, const LadderOptions& options) {
  return Ladder(chain, path, test, postures, start, options).run();
}

}  // namespace leadthrough::path
