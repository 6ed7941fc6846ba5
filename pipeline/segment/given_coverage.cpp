#include "pipeline/segment/given_coverage.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "pipeline/core/words.h"
#include "runtime/base/error.h"

namespace beatlas::segment {
namespace {

/// Of the voxels of a structure's labels: so many may say the opposite of its coverage.
constexpr double kMostOpposite = 0.05;

/// Labels tell a voxel by its centre, so it is at least touched where they have it, and not full
/// where they have not.
void check_one_body(const Grid& grid, const std::vector<std::uint8_t>& labels,
                    const PartCoverage& given, std::size_t phase, Structure structure) {
  const Grid& part = given.share.grid;
  std::size_t labelled = 0;
  std::size_t seen = 0;
  std::size_t opposite = 0;
  std::size_t v = 0;
  for (const std::uint8_t label : labels) labelled += label_in_structure(label, structure) ? 1 : 0;
  for (int k = 0; k < part.size[2]; ++k) {
    for (int j = 0; j < part.size[1]; ++j) {
      for (int i = 0; i < part.size[0]; ++i, ++v) {
        const std::size_t there =
            grid.offset(i + given.first[0], j + given.first[1], k + given.first[2]);
        const bool inside = label_in_structure(labels[there], structure);
        const float share = given.share.phases[phase][v];
        seen += inside ? 1 : 0;
        opposite += (inside ? share <= 0 : share >= 1) ? 1 : 0;
      }
    }
  }
  opposite += labelled - seen;
  if (static_cast<double>(opposite) <= kMostOpposite * static_cast<double>(labelled)) return;
  throw_invalid("the coverage of " + std::string(structure_name(structure)) +
                " and its labels, of " + counted(labelled, "voxel") + ", tell the opposite of " +
                counted(opposite, "voxel") + " in phase " + std::to_string(phase) +
                "; give those of one segmentation");
}

}  // namespace

void take_given_coverage(const GivenCoverage& given, Segmentation& segmentation) {
  CoverageCycle& coverage = segmentation.coverage;
  const LabelCycle& labels = segmentation.labels;
  for (const auto& [structure, part] : given) {
    const auto own = coverage.phases.find(structure);
    const std::string name(structure_name(structure));
    if (own == coverage.phases.end()) {
      throw_invalid("there is coverage of " + name +
                    ", but the labels hold none of it; leave it out or label it");
    }
    if (part.share.phase_count() != labels.phase_count()) {
      throw_invalid("the coverage of " + name + " holds " +
                    counted(part.share.phases.size(), "image") + ", but the exam has " +
                    counted(labels.phases.size(), "phase") + "; give one for each");
    }
    const Grid& grid = part.share.grid;
    for (std::size_t p = 0; p < labels.phases.size(); ++p) {
      check_one_body(labels.grid, labels.phases[p], part, p, structure);
      std::vector<float>& to = own->second[p];
      std::fill(to.begin(), to.end(), 0.0F);
      for (int k = 0; k < grid.size[2]; ++k) {
        for (int j = 0; j < grid.size[1]; ++j) {
          const auto row =
              part.share.phases[p].begin() + static_cast<std::ptrdiff_t>(grid.offset(0, j, k));
          const std::size_t at = coverage.grid.offset(part.first[0] - coverage.first[0],
                                                      j + part.first[1] - coverage.first[1],
                                                      k + part.first[2] - coverage.first[2]);
          std::copy(row, row + grid.size[0], to.begin() + static_cast<std::ptrdiff_t>(at));
        }
      }
    }
  }
}

}  // namespace beatlas::segment
