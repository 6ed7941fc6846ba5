#include "runtime/atlas/info.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "runtime/atlas/scene.h"
#include "runtime/atlas/structures.h"

namespace beatlas::atlas {
namespace {

template <class... Values>
std::string text(const char* format, Values... values) {
  std::array<char, 256> line{};
  std::snprintf(line.data(), line.size(), format, values...);
  return line.data();
}

bool has_images(const Manifest& manifest) { return manifest.source_size != Index3{0, 0, 0}; }

/// What the writer measured of the volume; null without one. Provenance may hold anything.
nlohmann::json volume_figures(const Manifest& manifest) {
  const auto held = [](const Item& item) { return item.kind == kVolumeKind; };
  if (std::none_of(manifest.items.begin(), manifest.items.end(), held)) return nullptr;
  nlohmann::json out = nlohmann::json::object();
  for (const char* name : {"noise", "quantum", "rms_error", "psnr_db"}) {
    const nlohmann::json::json_pointer at("/volume/" + std::string(name));
    const bool told = manifest.provenance.contains(at) && manifest.provenance[at].is_number();
    out[name] = told ? manifest.provenance[at] : nlohmann::json(nullptr);
  }
  return out;
}

/// Every surface in the package with what the writer measured of it.
nlohmann::json surface_levels(const Manifest& manifest) {
  nlohmann::json out = nlohmann::json::array();
  const auto of = [&](const Item& item) -> const nlohmann::json* {
    const auto told = manifest.provenance.find("surfaces");
    if (told == manifest.provenance.end() || !told->is_array()) return nullptr;
    for (const nlohmann::json& entry : *told) {
      if (entry.is_object() && entry.value("structure", nlohmann::json()) == item.structure &&
          entry.value("level", nlohmann::json()) == item.level) {
        return &entry;
      }
    }
    return nullptr;
  };
  for (const Item& item : manifest.items) {
    if (item.kind != kSurfaceKind) continue;
    const auto level = static_cast<std::size_t>(item.level);
    nlohmann::json figures{{"structure", item.structure}, {"level", item.level}};
    figures["edge_mm"] = level < manifest.surface_edges_mm.size()
                             ? nlohmann::json(manifest.surface_edges_mm[level])
                             : nlohmann::json(nullptr);
    const nlohmann::json* told = of(item);
    for (const char* name : {"vertices", "mean_mm", "worst_phase_mm", "bias_mm"}) {
      const bool is_there = told != nullptr && told->contains(name) && told->at(name).is_number();
      figures[name] = is_there ? told->at(name) : nlohmann::json(nullptr);
    }
    out.push_back(std::move(figures));
  }
  return out;
}

Vec3 spacing_mm(const Manifest& manifest) {
  return manifest.source_lps_from_index.linear().colwise().norm().transpose();
}

}  // namespace

std::optional<double> ejection_fraction(const Manifest& manifest) {
  for (const StructureEntry& entry : manifest.structures) {
    if (entry.name != structure_name(Structure::LvBlood)) continue;
    const double diastole = entry.volume_ml.at(static_cast<std::size_t>(manifest.end_diastole));
    const double systole = entry.volume_ml.at(static_cast<std::size_t>(manifest.end_systole));
    if (diastole > 0) return (diastole - systole) / diastole;
  }
  return std::nullopt;
}

nlohmann::json info_json(const Manifest& manifest) {
  nlohmann::json info = manifest_to_json(manifest);
  info["phases"] = manifest.phase_count();
  const std::optional<double> fraction = ejection_fraction(manifest);
  info["ejection_fraction"] = fraction ? nlohmann::json(*fraction) : nlohmann::json(nullptr);
  const Vec3 spacing = spacing_mm(manifest);
  info["volume"] = volume_figures(manifest);
  info["surface_levels"] = surface_levels(manifest);
  info["source"]["spacing_mm"] = {spacing.x(), spacing.y(), spacing.z()};
  return info;
}

std::string info_text(const Manifest& manifest) {
  std::string out = text("beatlas package, format %d, scene ", manifest.format_version);
  out += manifest.scene + "\n";
  out += text("cycle      R-R %.3f s, %d phases, end-diastole %d, end-systole %d\n",
              manifest.rr_interval_s, manifest.phase_count(), manifest.end_diastole,
              manifest.end_systole);
  const auto [first, last] =
      std::minmax_element(manifest.frame_times_s.begin(), manifest.frame_times_s.end());
  if (first != manifest.frame_times_s.end()) {
    out +=
        text("frames     %zu, at %.3f to %.3f s\n", manifest.frame_times_s.size(), *first, *last);
  }
  if (has_images(manifest)) {
    const Vec3 spacing = spacing_mm(manifest);
    out += text("source     %d x %d x %d voxels of %.3f x %.3f x %.3f mm\n",
                manifest.source_size[0], manifest.source_size[1], manifest.source_size[2],
                spacing.x(), spacing.y(), spacing.z());
  } else {
    out += "source     surfaces, no images\n";
  }
  out += text("material   %.1f N/m\n", manifest.stiffness_n_per_m);
  if (const std::optional<double> fraction = ejection_fraction(manifest)) {
    out += text("ejection   %.1f %% of the LV's blood\n", 100 * *fraction);
  }
  const nlohmann::json volume = volume_figures(manifest);
  if (volume.is_object() && volume["psnr_db"].is_number() && volume["noise"].is_number() &&
      volume["rms_error"].is_number()) {
    out += text("volume     PSNR %.1f dB, error %.4g rms in images of noise %.4g\n",
                volume["psnr_db"].get<double>(), volume["rms_error"].get<double>(),
                volume["noise"].get<double>());
  }
  out += "\nstructure       largest ml  smallest ml\n";
  for (const StructureEntry& entry : manifest.structures) {
    const auto [small, large] = std::minmax_element(entry.volume_ml.begin(), entry.volume_ml.end());
    if (small == entry.volume_ml.end()) continue;
    out += text("%-15s %10.1f  %11.1f\n", entry.name.c_str(), *large, *small);
  }
  const nlohmann::json levels = surface_levels(manifest);
  if (!levels.empty())
    out += "\nsurface          edge mm  vertices  mean error mm  of worst phase\n";
  for (const nlohmann::json& level : levels) {
    const auto number = [&](const char* name, const char* format) {
      const nlohmann::json& value = level[name];
      return value.is_number() ? text(format, value.get<double>()) : std::string("-");
    };
    out += text("%-15s %8s  %8s  %13s  %14s\n",
                level["structure"].get_ref<const std::string&>().c_str(),
                number("edge_mm", "%.3g").c_str(), number("vertices", "%.0f").c_str(),
                number("mean_mm", "%.4f").c_str(), number("worst_phase_mm", "%.4f").c_str());
  }
  out += "\npayload                                 bytes  sha256\n";
  for (const Item& item : manifest.items) {
    out += text("%-34s %10llu  ", item.path.c_str(), static_cast<unsigned long long>(item.bytes));
    out += item.sha256 + "\n";
  }
  return out;
}

}  // namespace beatlas::atlas
