#include "pipeline/study/given_files.h"

#include <bit>
#include <cstdint>
#include <set>
#include <span>
#include <system_error>

#include "pipeline/formats/nifti.h"
#include "pipeline/study/files.h"
#include "pipeline/study/images.h"
#include "pipeline/study/json_values.h"
#include "runtime/base/error.h"
#include "runtime/base/json_object.h"
#include "runtime/base/sha256.h"

namespace beatlas::study {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr auto kFolder = "given";
constexpr int kMostImages = 10000;

bool is_sha256(const std::string& text) {
  return text.size() == 64 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

/// By content, so that one is never written over another that study.json still tells of.
std::string name_of(const std::string& sha256) { return sha256.substr(0, 16) + ".nii.gz"; }

/// Of the grid of images.
std::string told(const Grid& grid) {
  std::string text;
  for (const int size : grid.size) text += std::to_string(size) + "\n";
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      const double value = grid.mm_from_index.matrix()(row, column);
      text += std::to_string(std::bit_cast<std::uint64_t>(value)) + "\n";
    }
  }
  return text;
}

/// Of the voxels.
template <class T>
std::string told(const std::vector<std::vector<T>>& images) {
  std::string text;
  for (const std::vector<T>& image : images) {
    text += sha256_hex(std::as_bytes(std::span(image))) + "\n";
  }
  return text;
}

std::string read_sha256(JsonObject& object, const std::string& key) {
  std::string text;
  object.read(key, text);
  if (!is_sha256(text)) throw_invalid(object.path() + "/" + key + " is no SHA-256");
  return text;
}

/// Writes the images unless they stand there already. @return what study.json tells of them
template <class Given, class Write>
json write_once(const fs::path& study, const Given& given, Write write) {
  const fs::path file = study / kFolder / name_of(given.sha256);
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) {
    make_folder(study / kFolder);
    write(file, given.images.phases, given.images.grid, 0);
  }
  return {{"sha256", given.sha256},
          {"file_sha256", given.file_sha256},
          {"grid", grid_to_json(given.images.grid)},
          {"images", given.images.phase_count()}};
}

}  // namespace

std::string given_sha256(const LabelCycle& images, const std::vector<int>& phases) {
  std::string text = "beatlas given labels 1\n";
  text += told(images.grid);
  for (const int phase : phases) text += std::to_string(phase) + " ";
  text += "\n";
  text += told(images.phases);
  return sha256_hex(std::as_bytes(std::span(text)));
}

std::string given_sha256(const ImageCycle<float>& images) {
  const std::string text = "beatlas given images 1\n" + told(images.grid) + told(images.phases);
  return sha256_hex(std::as_bytes(std::span(text)));
}

json write_given(const fs::path& study, const GivenLabels& given) {
  json told = write_once(study, given, write_labels);
  told["phases"] = given.phases;
  return told;
}

json write_given(const fs::path& study, const GivenImages& given) {
  return write_once(study, given, write_images);
}

GivenLabels read_given(const fs::path& study, const json& value, const std::string& path) {
  JsonObject object(value, path);
  GivenLabels out;
  out.sha256 = read_sha256(object, "sha256");
  out.file_sha256 = read_sha256(object, "file_sha256");
  const Grid grid = grid_from_json(object.at("grid"), path + "/grid");
  int images = 0;
  (void)object.at("images");
  object.read("images", images, 1, kMostImages);
  object.read("phases", out.phases, -1, kLastPhase);
  object.finish();
  const fs::path file = study / kFolder / name_of(out.sha256);
  std::error_code ignored;
  bool whole = fs::is_regular_file(file, ignored);
  if (whole) {
    out.images = read_labels(file, {grid, grid, images});
    whole = given_sha256(out.images, out.phases) == out.sha256;
  }
  if (!whole) {
    throw_invalid(file.string() +
                  " is gone or is not what was given; give the labels or the painting again");
  }
  return out;
}

GivenImages read_given_images(const fs::path& study, const json& value, const std::string& path) {
  JsonObject object(value, path);
  GivenImages out;
  out.sha256 = read_sha256(object, "sha256");
  out.file_sha256 = read_sha256(object, "file_sha256");
  const Grid grid = grid_from_json(object.at("grid"), path + "/grid");
  int images = 0;
  (void)object.at("images");
  object.read("images", images, 1, kMostImages);
  object.finish();
  const fs::path file = study / kFolder / name_of(out.sha256);
  std::error_code ignored;
  bool whole = fs::is_regular_file(file, ignored);
  if (whole) {
    out.images = read_images(file, {grid, grid, images});
    whole = given_sha256(out.images) == out.sha256;
  }
  if (!whole) {
    throw_invalid(file.string() +
                  " is gone or is not what was given; give the labels and their coverage again");
  }
  return out;
}

void clear_given(const fs::path& study, const std::vector<json>& kept) {
  std::set<std::string> names;
  for (const json& given : kept) {
    for (const auto& item : given.items()) {
      const auto hash = item.value().find("sha256");
      if (hash != item.value().end() && hash->is_string()) {
        names.insert(name_of(hash->get<std::string>()));
      }
    }
  }
  std::error_code ignored;
  std::vector<fs::path> others;
  for (fs::directory_iterator it(study / kFolder, ignored), end; !ignored && it != end;
       it.increment(ignored)) {
    const std::string name = it->path().filename().string();
    const bool ours =
        name.ends_with(".nii.gz") && name.size() == name_of(std::string(64, '0')).size();
    if (ours && names.count(name) == 0) others.push_back(it->path());
  }
  for (const fs::path& file : others) fs::remove(file, ignored);
}

}  // namespace beatlas::study
