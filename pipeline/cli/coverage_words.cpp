#include "pipeline/cli/coverage_words.h"

#include <algorithm>
#include <optional>
#include <set>
#include <system_error>

#include "pipeline/core/box.h"
#include "pipeline/formats/nifti.h"
#include "pipeline/ingest/shown_path.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace fs = std::filesystem;
namespace {

constexpr auto kPrefix = "coverage_";
constexpr auto kSuffix = ".nii.gz";
constexpr float kRounding = 1e-4F;  ///< beyond 0..1, as a scaled image may have it

ImageCycle<float> without_rim(const ImageCycle<float>& images) {
  std::vector<std::uint8_t> covered(images.grid.count());
  for (const std::vector<float>& image : images.phases) {
    for (std::size_t v = 0; v < image.size(); ++v) covered[v] |= image[v] > 0 ? 1 : 0;
  }
  const Box box = box_around(images.grid, covered);
  if (box.empty()) throw_invalid("it covers nothing: all its voxels are 0; leave it out");
  return crop(images, box);
}

study::GivenImages read_shares(const fs::path& file) {
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
      out[*structure] = read_shares(folder / name);
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

}  // namespace beatlas::cli
