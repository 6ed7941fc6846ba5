#include "runtime/atlas/manifest.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "runtime/atlas/scene.h"
#include "runtime/atlas/structures.h"
#include "runtime/base/error.h"
#include "runtime/base/json_object.h"

namespace beatlas::atlas {
namespace {

using nlohmann::json;

constexpr double kRigidTolerance = 1e-3;
constexpr std::size_t kMaxFrames = 100000;
constexpr std::size_t kMaxStructures = 256;
constexpr std::size_t kMaxItems = 1000;
constexpr int kMaxNesting = 32;

double required_number(JsonObject& object, const std::string& key, double low, double high) {
  double value = 0;
  (void)object.at(key);
  object.read(key, value, low, high);
  return value;
}

int required_int(JsonObject& object, const std::string& key, int low, int high) {
  int value = 0;
  (void)object.at(key);
  object.read(key, value, low, high);
  return value;
}

std::string required_text(JsonObject& object, const std::string& key) {
  std::string value;
  (void)object.at(key);
  object.read(key, value);
  return value;
}

const json& required_array(JsonObject& object, const std::string& key, std::size_t low,
                           std::size_t high) {
  const json& array = object.at(key);
  if (!array.is_array() || array.size() < low || array.size() > high) {
    throw_invalid(object.path() + "/" + key + " must be a list of " + std::to_string(low) +
                  (low == high ? "" : " to " + std::to_string(high)) + " entries");
  }
  return array;
}

/// @param path of the list
std::vector<double> numbers_in(const json& array, const std::string& path, double least,
                               double most) {
  std::vector<double> values;
  values.reserve(array.size());
  for (const json& entry : array) {
    const double value = entry.is_number() ? entry.get<double>() : std::nan("");
    if (!(value >= least && value <= most)) {
      throw_invalid(path + "/" + std::to_string(values.size()) + " must be a number from " +
                    std::to_string(least) + " to " + std::to_string(most));
    }
    values.push_back(value);
  }
  return values;
}

std::vector<double> required_numbers(JsonObject& object, const std::string& key, std::size_t low,
                                     std::size_t high, double least, double most) {
  return numbers_in(required_array(object, key, low, high), object.path() + "/" + key, least, most);
}

json affine_to_json(const Affine& affine) {
  json numbers = json::array();
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) numbers.push_back(affine.matrix()(row, column));
  }
  return numbers;
}

Affine required_affine(JsonObject& object, const std::string& key) {
  const std::vector<double> numbers = required_numbers(object, key, 16, 16, -1e6, 1e6);
  Affine affine;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      affine.matrix()(row, column) = numbers[static_cast<std::size_t>(4 * row + column)];
    }
  }
  if (affine.matrix().row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
    throw_invalid(object.path() + "/" + key + " must end with the row 0 0 0 1");
  }
  if (!(std::abs(affine.linear().determinant()) > 1e-9)) {
    throw_invalid(object.path() + "/" + key + " must be invertible");
  }
  return affine;
}

void require_at(bool ok, const std::string& path, const std::string& what) {
  if (!ok) throw_invalid(path + " " + what);
}

constexpr double kMostBandMm = 1000;

/// [phase][slice]
std::vector<std::vector<double>> band_table(JsonObject& object, const std::string& key,
                                            std::size_t phases, std::size_t slices) {
  std::vector<std::vector<double>> out;
  for (const json& phase : required_array(object, key, phases, phases)) {
    const std::string path = object.path() + "/" + key + "/" + std::to_string(out.size());
    require_at(phase.is_array() && phase.size() == slices, path,
               "must be a list of as many entries as the source has slices");
    out.push_back(numbers_in(phase, path, 0, kMostBandMm));
  }
  return out;
}

SurfaceBand band_from_json(const json& entry, const std::string& path, std::size_t phases,
                           std::size_t slices) {
  require_at(slices > 0, path, "must not be there, for the source has no slices");
  JsonObject object(entry, path);
  SurfaceBand band;
  band.across_mm = band_table(object, "across_mm", phases, slices);
  band.along_mm = band_table(object, "along_mm", phases, slices);
  object.finish();
  return band;
}

/// @param manifest as far as its source
StructureEntry structure_from_json(const json& entry, const std::string& path,
                                   const Manifest& manifest) {
  JsonObject object(entry, path);
  StructureEntry structure;
  structure.name = required_text(object, "name");
  const auto known = structure_from_name(structure.name);
  require_at(known && (manifest.format_version >= 5 || !is_beyond_base(*known)), path + "/name",
             "is not a structure this format knows");
  structure.volume_ml = required_numbers(object, "volume_ml", 1, kMaxPhases, 0, 1e6);
  if (object.has("band")) {
    require_at(manifest.format_version >= 7, path + "/band", "is not of this format version");
    structure.band = band_from_json(object.at("band"), path + "/band", structure.volume_ml.size(),
                                    static_cast<std::size_t>(manifest.source_size[2]));
  }
  object.finish();
  return structure;
}

Item item_from_json(const json& entry, const std::string& path, int format_version) {
  JsonObject object(entry, path);
  Item item;
  item.kind = required_text(object, "kind");
  require_at(is_kind(item.kind), path + "/kind",
             "must be field, surface, motion, surface_map or volume");
  require_at(item.kind != kMapKind || format_version >= 4, path + "/kind",
             "is not of this format version");
  item.structure = required_text(object, "structure");
  const auto structure = structure_from_name(item.structure);
  require_at(structure.has_value(), path + "/structure", "is not a structure this format knows");
  if (object.has("level")) {
    require_at(format_version >= 5 && has_levels(item.kind), path + "/level",
               "is not of this kind or format version");
    item.level = required_int(object, "level", 1, kMaxSurfaceLevels - 1);
  }
  item.path = required_text(object, "path");
  require_at(item.kind != kVolumeKind || *structure == Structure::Heart, path + "/structure",
             "must be heart for a volume");
  require_at(kind_exists(item.kind, *structure), path + "/structure",
             "must be lv_blood, lv_myocardium or rv_blood for a surface_map");
  require_at(item.kind != kMapKind || *structure != Structure::RvBlood || format_version >= 6,
             path + "/structure", "must be lv_blood or lv_myocardium before format version 6");
  const std::string expected = item_path(item.kind, *structure, item.level);
  require_at(item.path == expected, path + "/path", "must be " + expected);
  const json& bytes = object.at("bytes");
  require_at(bytes.is_number_unsigned(), path + "/bytes", "must be a whole number, at least 0");
  item.bytes = bytes.get<std::uint64_t>();
  item.sha256 = required_text(object, "sha256");
  require_at(item.sha256.size() == 64 &&
                 item.sha256.find_first_not_of("0123456789abcdef") == std::string::npos,
             path + "/sha256", "must be 64 lower-case hexadecimal digits");
  object.finish();
  return item;
}

void check_version(const json& document) {
  if (!document.is_object()) throw_invalid("atlas.json must be a JSON object");
  const auto format = document.find("format");
  require_at(format != document.end() && format->is_string() && *format == std::string(kFormatName),
             "/format",
             std::string("must be \"").append(kFormatName).append("\"; this is no package"));
  const auto version = document.find("format_version");
  require_at(version != document.end() && version->is_number_integer(), "/format_version",
             "must be a whole number");
  if (version->get<double>() > kFormatVersion) {
    throw_invalid("format version " + version->dump() + " is newer than version " +
                  std::to_string(kFormatVersion) +
                  ", the newest this program reads; update beatlas");
  }
  require_at(version->get<double>() >= 1, "/format_version", "must be at least 1");
  if (version->get<double>() < kOldestFormatVersion) {
    throw_invalid("format version " + version->dump() + " is older than version " +
                  std::to_string(kOldestFormatVersion) +
                  ", the oldest this program reads; build the package again");
  }
}

void read_source(JsonObject& parent, Manifest& manifest) {
  JsonObject source(parent.at("source"), "/source");
  const auto size = required_numbers(source, "size", 3, 3, 0, 65535);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    manifest.source_size[axis] = static_cast<int>(size[axis]);
    require_at(manifest.source_size[axis] == size[axis], "/source/size", "must hold whole numbers");
  }
  manifest.source_lps_from_index = required_affine(source, "lps_from_index");
  source.finish();
}

}  // namespace

Manifest manifest_from_json(const json& document) {
  check_version(document);
  Manifest manifest;
  JsonObject object(document, "");
  (void)object.at("format");
  manifest.format_version =
      required_int(object, "format_version", kOldestFormatVersion, kFormatVersion);
  manifest.scene = required_text(object, "scene");
  require_at(is_scene(manifest.scene), "/scene", "must be palpation, anatomy or full");
  manifest.rr_interval_s = required_number(object, "rr_interval_s", 0.02, 20);
  manifest.frame_times_s = required_numbers(object, "frame_times_s", 1, kMaxFrames, -100, 100);
  manifest.workspace_from_lps = required_affine(object, "workspace_from_lps");
  const Eigen::Matrix3d rotation = manifest.workspace_from_lps.linear();
  require_at(
      (rotation.transpose() * rotation).isIdentity(kRigidTolerance) && rotation.determinant() > 0,
      "/workspace_from_lps", "must be rigid: lengths and handedness are never changed");
  read_source(object, manifest);
  JsonObject material(object.at("material"), "/material");
  manifest.stiffness_n_per_m = required_number(material, "stiffness_n_per_m", 0, 1e6);
  material.finish();

  std::set<std::string> names;
  const json& structures = required_array(object, "structures", 1, kMaxStructures);
  for (std::size_t i = 0; i < structures.size(); ++i) {
    const std::string path = "/structures/" + std::to_string(i);
    manifest.structures.push_back(structure_from_json(structures[i], path, manifest));
    const StructureEntry& entry = manifest.structures.back();
    require_at(names.insert(entry.name).second, path + "/name", "must not be given twice");
    require_at(static_cast<int>(entry.volume_ml.size()) == manifest.phase_count(),
               path + "/volume_ml", "must have as many phases as that of the first structure");
  }
  manifest.end_diastole = required_int(object, "end_diastole", 0, manifest.phase_count() - 1);
  manifest.end_systole = required_int(object, "end_systole", 0, manifest.phase_count() - 1);

  if (manifest.format_version >= 5) {
    manifest.surface_edges_mm =
        required_numbers(object, "surface_edges_mm", 0, kMaxSurfaceLevels, 0.1, 100);
    const std::vector<double>& edges = manifest.surface_edges_mm;
    require_at(
        std::adjacent_find(edges.begin(), edges.end(), std::greater_equal<>()) == edges.end(),
        "/surface_edges_mm", "must rise");
  }
  std::set<std::string> paths;
  const json& items = required_array(object, "items", 0, kMaxItems);
  for (std::size_t i = 0; i < items.size(); ++i) {
    const std::string path = "/items/" + std::to_string(i);
    manifest.items.push_back(item_from_json(items[i], path, manifest.format_version));
    const Item& item = manifest.items.back();
    require_at(paths.insert(item.path).second, path + "/path", "must not be given twice");
    require_at(names.count(item.structure) == 1, path + "/structure",
               "must be one of those listed under structures");
    require_at(item.level == 0 || item.level < static_cast<int>(manifest.surface_edges_mm.size()),
               path + "/level", "must be one of surface_edges_mm");
  }
  manifest.provenance = object.at("provenance");
  require_at(manifest.provenance.is_object(), "/provenance", "must be a JSON object");
  object.finish();
  return manifest;
}

json manifest_to_json(const Manifest& manifest) {
  json structures = json::array();
  for (const StructureEntry& entry : manifest.structures) {
    structures.push_back({{"name", entry.name}, {"volume_ml", entry.volume_ml}});
    if (!entry.band) continue;
    structures.back()["band"] = {{"across_mm", entry.band->across_mm},
                                 {"along_mm", entry.band->along_mm}};
  }
  json items = json::array();
  for (const Item& item : manifest.items) {
    items.push_back({{"path", item.path},
                     {"kind", item.kind},
                     {"structure", item.structure},
                     {"bytes", item.bytes},
                     {"sha256", item.sha256}});
    if (item.level > 0) items.back()["level"] = item.level;
  }
  json out{{"format", kFormatName},
           {"format_version", manifest.format_version},
           {"scene", manifest.scene},
           {"rr_interval_s", manifest.rr_interval_s},
           {"frame_times_s", manifest.frame_times_s},
           {"workspace_from_lps", affine_to_json(manifest.workspace_from_lps)},
           {"source",
            {{"size", manifest.source_size},
             {"lps_from_index", affine_to_json(manifest.source_lps_from_index)}}},
           {"material", {{"stiffness_n_per_m", manifest.stiffness_n_per_m}}},
           {"end_diastole", manifest.end_diastole},
           {"end_systole", manifest.end_systole},
           {"structures", std::move(structures)},
           {"items", std::move(items)},
           {"provenance", manifest.provenance}};
  if (manifest.format_version >= 5) out["surface_edges_mm"] = manifest.surface_edges_mm;
  return out;
}

bool holds_surface(const Manifest& manifest, Structure structure, int level) {
  return std::any_of(manifest.items.begin(), manifest.items.end(), [&](const Item& item) {
    return item.kind == kSurfaceKind && item.level == level &&
           item.structure == structure_name(structure);
  });
}

Manifest manifest_from_text(std::string_view text) {
  std::vector<std::set<std::string>> open_objects;
  const auto watch = [&open_objects](int depth, json::parse_event_t event, json& value) {
    if (depth >= kMaxNesting) throw_invalid("atlas.json is nested too deeply; this is no package");
    if (event == json::parse_event_t::object_start) {
      open_objects.emplace_back();
    } else if (event == json::parse_event_t::object_end) {
      open_objects.pop_back();
    } else if (event == json::parse_event_t::key) {
      if (!open_objects.back().insert(value.get<std::string>()).second) {
        throw_invalid("atlas.json gives a key twice; build the package again");
      }
    }
    return true;
  };
  json document;
  try {
    document = json::parse(text.begin(), text.end(), watch);
  } catch (const json::exception&) {
    throw_invalid("atlas.json is not JSON; copy or build the package again");
  }
  return manifest_from_json(document);
}

}  // namespace beatlas::atlas
