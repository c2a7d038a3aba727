#pragma once

// Tests of whether edges, straight in the joints, are collision-free all along, and the same for
// single configurations, eight at once.
//
// Balls contain every body of the arm (ball_cover.hpp). Around the middle of a segment of an edge a
// ball keeps its distance to an obstacle, less what it can move in half the segment: one
// configuration certifies the segment, eight middles are looked at together, and segments that are
// not certified are halved. Bodies nearer than their balls can tell are left to exact distances.

#include <memory>
#include <vector>

#include "leadthrough/collision/clearance.hpp"

namespace leadthrough {

// One per thread.
class EdgeTest {
 public:
  explicit EdgeTest(const WholeArm& arm);
  ~EdgeTest();

  // True if every pair keeps its margin from q to end. Within 0.1 mm of its margin, motion may
  // count as a collision.
  bool clear(const double* q, const double* end);
  // The same for `count` configurations in rows, at most eight: bit i for row i.
  unsigned clear_rows(const double* q, int count);

 private:
  class Search;
  std::unique_ptr<Search> search_;
};

// One flag per row of q: true if it is clear.
std::vector<bool> clear_batch(const WholeArm& arm, const RowsRef& q);
// One flag per edge, from a row of starts to that of ends.
std::vector<bool> clear_edges(const WholeArm& arm, const RowsRef& starts, const RowsRef& ends,
                              int threads);

}  // namespace leadthrough
