#include "pipeline/cli/coverage_words.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <system_error>

#include "pipeline/formats/nifti.h"
#include "pipeline/ingest/shown_path.h"
#include "pipeline/segment/tissue.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace fs = std::filesystem;
namespace {

constexpr auto kPrefix = "coverage_";
constexpr auto kSuffix = ".nii.gz";
constexpr float kRounding = 1e-4F;        ///< beyond 0..1, as a scaled image may have it
constexpr double kPlaceTolerance = 0.01;  ///< [voxels]

ImageCycle<float> without_rim(const ImageCycle<float>& images) {
  std::vector<std::uint8_t> covered(images.grid.count());
  for (const std::vector<float>& image : images.phases) {
    for (std::size_t v = 0; v < image.size(); ++v) covered[v] |= image[v] > 0 ? 1 : 0;
  }
  const segment::Box box = segment::box_around(images.grid, covered);
  if (box.empty()) throw_invalid("it covers nothing: all its voxels are 0; leave it out");
  return segment::crop(images, box);
}

study::GivenImages read_one(const fs::path& file) {
  study::GivenImages out;
  ImageCycle<float> images = formats::read_nifti(file);
  for (std::vector<float>& image : images.phases) {
    for (float& share : image) {
      if (!(share >= -kRounding && share <= 1 + kRounding)) {
        throw_invalid("it holds the value " + std::to_string(share) +
                      "; coverage is the share of a voxel, 0 to 1");
      }
      share = std::clamp(share, 0.0F, 1.0F);
    }
  }
  out.images = without_rim(images);
  out.file_sha256 = study::sha256_of_file(file);
  out.sha256 = study::given_sha256(out.images);
  return out;
}

std::string coverage_names() {
  std::string out;
  for (const Structure structure : kAllStructures) {
    out += (out.empty() ? "" : ", ") + std::string(structure_name(structure));
  }
  return out;
}

}  // namespace

std::string coverage_file_name(Structure structure) {
  return kPrefix + std::string(structure_name(structure)) + kSuffix;
}

std::map<Structure, study::GivenImages> read_coverage(const fs::path& folder) {
  std::map<Structure, study::GivenImages> out;
  const std::string shown = ingest::shown_to({folder}, folder);
  std::error_code error;
  std::set<std::string> names;  // in order, so that the same is refused whatever the folder's
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    names.insert(it->path().filename().string());
  }
  if (error) throw_invalid(shown + " is no folder that can be read; --coverage names one");
  for (const std::string& name : names) {
    if (!name.starts_with(kPrefix) || !name.ends_with(kSuffix)) continue;
    const std::size_t from = std::string_view(kPrefix).size();
    const std::string word =
        name.substr(from, name.size() - from - std::string_view(kSuffix).size());
    const std::optional<Structure> structure = structure_from_name(word);
    if (!structure) {
      throw_invalid(ingest::shown_to({folder}, folder / name) +
                    ": its name ends with no structure; coverage is told of " + coverage_names());
    }
    try {
      out[*structure] = read_one(folder / name);
    } catch (const Error& wrong) {
      std::string said = wrong.what();
      const std::string named = (folder / name).string() + ": ";
      if (said.starts_with(named)) said.erase(0, named.size());
      throw Error(wrong.code(), said).with_context(ingest::shown_to({folder}, folder / name));
    }
  }
  if (out.empty()) {
    throw_invalid(shown + " holds no coverage_STRUCTURE.nii.gz; STRUCTURE is one of " +
                  coverage_names());
  }
  return out;
}

segment::PartCoverage on_voxels_of(const ImageCycle<float>& images, Structure structure,
                                   const Grid& grid) {
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
  segment::PartCoverage out;
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

}  // namespace beatlas::cli
