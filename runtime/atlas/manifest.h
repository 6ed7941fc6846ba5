#pragma once
/// atlas.json, the first entry of every package: what is in it and where it came from.

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime/base/geometry.h"

namespace beatlas::atlas {

inline constexpr int kFormatVersion = 1;

/// A payload: entry name in the zip, size and SHA-256 of the entry as a zip tool extracts it.
struct Item {
  std::string path;
  std::string kind;  ///< "field", "surface", ...
  std::string structure;
  std::uint64_t bytes = 0;
  std::string sha256;
};

struct StructureEntry {
  std::string name;               ///< see structures.h
  std::vector<double> volume_ml;  ///< enclosed volume of each phase
};

struct Manifest {
  int format_version = kFormatVersion;
  std::string scene = "full";
  double rr_interval_s = 0;
  std::vector<double> frame_times_s;  ///< the source's frame times
  Affine workspace_from_lps = Affine::Identity();
  Index3 source_size{0, 0, 0};
  Affine source_lps_from_index = Affine::Identity();
  double stiffness_n_per_m = 150;  ///< uniform material
  int end_diastole = 0;
  int end_systole = 0;
  std::vector<StructureEntry> structures;
  std::vector<Item> items;
  nlohmann::json provenance = nlohmann::json::object();  ///< stages, options, versions, hashes
};

/// @throws Error{InvalidInput} naming the JSON path of what is missing, unknown or out of range.
[[nodiscard]] Manifest manifest_from_json(const nlohmann::json& json);
[[nodiscard]] nlohmann::json manifest_to_json(const Manifest& manifest);

}  // namespace beatlas::atlas
