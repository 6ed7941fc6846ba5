#include "pipeline/cli/key_surfaces.h"

#include <algorithm>
#include <string>

#include "pipeline/formats/surface_file.h"
#include "pipeline/keyframes/periodic_spline.h"
#include "pipeline/study/files.h"
#include "pipeline/study/ply.h"
#include "runtime/base/error.h"
#include "runtime/base/json_object.h"

namespace beatlas::cli {
namespace fs = std::filesystem;
namespace {

field::TriangleSoup read_one(const fs::path& file) {
  std::string end = file.extension().string();
  std::transform(end.begin(), end.end(), end.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  field::TriangleSoup out;
  if (end == ".ply") {
    study::TriangleMesh mesh = study::read_ply(file);
    for (const Vec3f& vertex : mesh.vertices) out.points.push_back(vertex.cast<double>());
    out.triangles = std::move(mesh.triangles);
  } else if (end == ".obj" || end == ".stl") {
    formats::SurfaceMesh mesh = end == ".obj" ? formats::read_obj(file) : formats::read_stl(file);
    out = {std::move(mesh.points), std::move(mesh.triangles)};
  } else {
    throw_invalid(file.string() + ": a key surface is a .ply, .obj or .stl file");
  }
  return out;
}

std::vector<std::string> names_at(const nlohmann::json& list, const std::string& path) {
  std::vector<std::string> out;
  if (list.is_array()) {
    for (const nlohmann::json& name : list) {
      if (name.is_string()) out.push_back(name.get<std::string>());
    }
  }
  if (out.empty() || out.size() != list.size() || out.size() > 200) {
    throw_invalid(path + " must be a list of 1 to 200 file names");
  }
  return out;
}

KeySurfaces from_json(const nlohmann::json& json, const fs::path& folder) {
  KeySurfaces out;
  keyframes::KeyHeart& heart = out.heart;
  JsonObject object(json, "");
  (void)object.at("rr_interval_s");
  object.read("rr_interval_s", heart.rr_interval_s, 0.02, 20);
  (void)object.at("phases");
  object.read("phases", heart.phases, 3, 200);
  object.read("voxel_mm", heart.voxel_mm, 0.3, 5);
  int contraction = 0;
  object.read("contraction_phases", contraction, 1, heart.phases - 1);
  std::vector<double> times_s;
  object.read("key_times_s", times_s, 0, heart.rr_interval_s);
  const nlohmann::json& structures = object.at("structures");
  object.finish();
  if ((contraction == 0) == times_s.empty()) {
    throw_invalid(
        "give either /key_times_s, the moment of every key, or /contraction_phases, where keys run "
        "from end-diastole to end-systole and back");
  }
  if (!structures.is_object()) throw_invalid("/structures must be an object");
  std::map<Structure, std::vector<std::string>> names;
  std::size_t keys = 0;
  for (const auto& [name, list] : structures.items()) {
    const std::string path = "/structures/" + name;
    const auto structure = structure_from_name(name);
    if (!structure) throw_invalid(path + ": there is no such structure");
    const auto& files = names[*structure] = names_at(list, path);
    if (keys != 0 && files.size() != keys) {
      throw_invalid(path + " must name as many files as the other structures do");
    }
    keys = files.size();
  }
  std::vector<int> order;
  if (contraction > 0) {
    keyframes::ThereAndBack both = keyframes::there_and_back(
        static_cast<int>(keys), static_cast<double>(contraction) / heart.phases);
    heart.key_at = std::move(both.at);
    order = std::move(both.key);
  } else {
    if (times_s.size() != keys) {
      throw_invalid("/key_times_s must have a time for each of the " + std::to_string(keys) +
                    " key surfaces");
    }
    for (const double time_s : times_s) {
      order.push_back(static_cast<int>(order.size()));
      heart.key_at.push_back(time_s / heart.rr_interval_s);
    }
  }
  for (const auto& [structure, files] : names) {
    std::vector<field::TriangleSoup> read;
    for (const std::string& name : files) {
      out.files.push_back(folder / name);
      read.push_back(read_one(out.files.back()));
    }
    for (const int key : order) {
      heart.surfaces[structure].push_back(read[static_cast<std::size_t>(key)]);
    }
  }
  return out;
}

}  // namespace

KeySurfaces read_key_surfaces(const fs::path& json_file) {
  const nlohmann::json json = study::read_json(json_file);
  try {
    KeySurfaces out = from_json(json, json_file.parent_path());
    out.files.insert(out.files.begin(), json_file);
    return out;
  } catch (const Error& error) {
    throw error.with_context(json_file.string());
  }
}

}  // namespace beatlas::cli
