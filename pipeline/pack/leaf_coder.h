#pragma once
/// Coefficients of leaves -> their terms, as runtime/atlas/leaf_terms.h says they are written.
/// Fields and volumes share it.

#include <array>
#include <cstdint>
#include <vector>

#include "runtime/atlas/bytes.h"
#include "runtime/atlas/field_transform.h"
#include "runtime/atlas/leaf_terms.h"

namespace beatlas::pack {

/// Counts of one leaf's terms, [mode][rank].
using TermCounts = std::vector<std::int32_t>;

/// How a share of a count becomes a count.
struct Rounding {
  double zero_below = 0.5;     ///< shares less than this are 0
  double round_up_from = 0.5;  ///< others are rounded down up to this fraction
};

class LeafCoder {
 public:
  /// @param coefficients those of all leaves, [leaf][z][y][phase][x]; kept by reference
  /// @param quantum of grade 0, in counts of the coefficients
  LeafCoder(const std::vector<std::int16_t>& coefficients, int phases, atlas::LeafTransform::Of of,
            double quantum, const Rounding& rounding);

  /// @throws Error{InvalidInput} if the quantum is too small for the coefficients
  [[nodiscard]] TermCounts counts(std::size_t leaf, int grade) const;

 private:
  /// Terms in counts of the coefficients, [mode][place].
  [[nodiscard]] std::vector<double> forward(std::size_t leaf) const;

  const std::vector<std::int16_t>& coefficients_;
  double quantum_;
  Rounding rounding_;
  atlas::LeafTransform transform_;
  std::size_t phases_;
};

/// What follows the header of a payload, but the grades: leaf after leaf.
class LeafBody {
 public:
  void add(const TermCounts& counts);
  [[nodiscard]] std::size_t apart_count() const { return apart_.size(); }
  void write(const std::vector<std::uint8_t>& grades, atlas::ByteWriter& writer) const;

 private:
  /// What of one mode's terms, of which `length` are not cut off, lies in a band.
  void add_band(std::size_t band, const std::int32_t* terms, std::size_t length);

  std::vector<std::uint16_t> lengths_;
  std::vector<std::uint32_t> apart_counts_;
  std::array<std::vector<std::uint8_t>, atlas::kBands> bands_;
  std::vector<std::uint32_t> apart_;
};

}  // namespace beatlas::pack
