#include "pipeline/segment/given_coverage.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "pipeline/core/words.h"
#include "runtime/base/error.h"

namespace beatlas::segment {
namespace {

/// Of the voxels of a structure's labels: so many may say the opposite of its coverage.
constexpr double kMostOpposite = 0.05;
/// [voxels] An image that lies this far off the exam's voxels is still on them.
constexpr double kPlaceTolerance = 0.01;

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

PartCoverage on_voxels_of(const ImageCycle<float>& images, Structure structure, const Grid& grid) {
  const std::string name(structure_name(structure));
  const Grid& given = images.grid;
  const Affine index_from_given = grid.mm_from_index.inverse() * given.mm_from_index;
  const Eigen::Matrix3d turn = index_from_given.linear().array().round();
  const Vec3 shift = index_from_given.translation().array().round();
  // At the corners a turn of the axes shows most.
  double astray = std::abs(std::abs(turn.determinant()) - 1);
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 at((corner & 1) != 0 ? given.size[0] - 1 : 0,
                  (corner & 2) != 0 ? given.size[1] - 1 : 0,
                  (corner & 4) != 0 ? given.size[2] - 1 : 0);
    const Vec3 there = turn * at + shift;
    astray = std::max(astray, (index_from_given * at - there).cwiseAbs().maxCoeff());
    low = low.cwiseMin(there);
    high = high.cwiseMax(there);
  }
  if (!(astray <= kPlaceTolerance)) {
    throw_invalid("the coverage of " + name +
                  " lies between the images' voxels; save it on the grid of the images");
  }
  PartCoverage out;
  Index3 size{};
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    out.first[a] = static_cast<int>(low[axis]);
    size[a] = static_cast<int>(high[axis] - low[axis]) + 1;
    if (low[axis] < 0 || high[axis] > grid.size[a] - 1) {
      throw_invalid(
          "the coverage of " + name +
          " reaches beyond the images in the patient's space; it belongs to another exam, "
          "or was moved or mirrored");
    }
  }
  out.share.grid = grid.part(out.first, size);
  out.share.phases.resize(images.phases.size());
  for (std::size_t p = 0; p < images.phases.size(); ++p) {
    out.share.phases[p].resize(given.count());
    std::size_t v = 0;
    for (int k = 0; k < given.size[2]; ++k) {
      for (int j = 0; j < given.size[1]; ++j) {
        for (int i = 0; i < given.size[0]; ++i, ++v) {
          const Vec3 at = turn * Vec3(i, j, k) + shift - low;
          out.share.phases[p][out.share.grid.offset(
              static_cast<int>(at[0]), static_cast<int>(at[1]), static_cast<int>(at[2]))] =
              images.phases[p][v];
        }
      }
    }
  }
  return out;
}

}  // namespace beatlas::segment
