#pragma once
/// atlas.json, the first entry of every package: what is in it and where it came from.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime/atlas/structures.h"
#include "runtime/base/geometry.h"

namespace beatlas::atlas {

inline constexpr int kFormatVersion = 7;
/// Version 6 had no bands of surfaces. Version 5 had no map of rv_blood. Version 4 had one level of
/// surfaces and did not tell their edges. Version 3 had no surface maps, and a palpation scene of
/// the heart's field alone.
inline constexpr int kOldestFormatVersion = 3;

inline constexpr std::string_view kManifestEntry = "atlas.json";
inline constexpr std::string_view kFormatName = "beatlas";

/// A payload: entry name in the zip, size and SHA-256 of the entry as a zip tool extracts it.
struct Item {
  std::string path;  ///< item_path(kind, structure, level), see scene.h
  std::string kind;  ///< one of kKinds
  std::string structure;
  std::uint64_t bytes = 0;
  std::string sha256;
  int level = 0;  ///< of a surface, its motion and its map: index of surface_edges_mm
};

/// What is known of how far off a structure's surface may lie; see BandQuery for its use.
struct SurfaceBand {
  /// [phase][slice of the source] [mm] 0..1000: within slices, along an outline's normal.
  std::vector<std::vector<double>> across_mm;
  std::vector<std::vector<double>> along_mm;  ///< the same across slices, along their normal
};

struct StructureEntry {
  std::string name;                      ///< see structures.h
  std::vector<double> volume_ml;         ///< enclosed volume of each phase, >= 0
  std::optional<SurfaceBand> band = {};  ///< none where it is not known, and before version 7
};

/// Ranges (checked on reading and on writing) are wide enough for any mammal and any scanner.
struct Manifest {
  int format_version = kFormatVersion;
  std::string scene = "full";         ///< one of kScenes
  double rr_interval_s = 0;           ///< [s] 0.02..20
  std::vector<double> frame_times_s;  ///< [s] -100..100; the source's frame times, at least one
  Affine workspace_from_lps = Affine::Identity();  ///< rigid (to 1e-3), determinant +1
  Index3 source_size{0, 0, 0};                     ///< {0, 0, 0}: not made from images
  Affine source_lps_from_index = Affine::Identity();
  double stiffness_n_per_m = 150;  ///< [N/m] 0..1e6; uniform material
  int end_diastole = 0;
  int end_systole = 0;
  std::vector<StructureEntry> structures;  ///< at least one; all with equally many phases
  /// [level] [mm] 0.1..100, each more than the one before: what triangles' edges of a level of
  /// detail are about as long as, the finest first. Every structure with a surface has level 0; it
  /// lacks a coarser one that it is too small for. Empty without surfaces and before version 5,
  /// when surfaces had level 0 alone.
  std::vector<double> surface_edges_mm;
  std::vector<Item> items;
  nlohmann::json provenance = nlohmann::json::object();  ///< stages, options, versions, hashes

  /// Phases of the cycle, the same for every structure and payload; 0 if there is no structure.
  [[nodiscard]] int phase_count() const {
    return structures.empty() ? 0 : static_cast<int>(structures.front().volume_ml.size());
  }
};

/// Whether the package holds a surface of the structure at this level of detail.
[[nodiscard]] bool holds_surface(const Manifest& manifest, Structure structure, int level);

inline constexpr int kMaxPhases = 1024;
inline constexpr int kMaxSurfaceLevels = 8;

/// Follows schemas/manifest.schema.json and every range above.
/// @throws Error{InvalidInput} naming the JSON path of what is missing, unknown or out of range; a
/// format of another version is refused by its number before anything else is looked at.
[[nodiscard]] Manifest manifest_from_json(const nlohmann::json& json);
[[nodiscard]] nlohmann::json manifest_to_json(const Manifest& manifest);

/// The text of atlas.json. Beside manifest_from_json, refuses a key given twice and nesting deeper
/// than 32, so that no later use of `provenance` can exhaust the stack.
[[nodiscard]] Manifest manifest_from_text(std::string_view text);

}  // namespace beatlas::atlas
