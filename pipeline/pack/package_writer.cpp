#include <algorithm>

#include "pipeline/core/parallel.h"
#include "pipeline/pack/pack.h"
#include "pipeline/pack/payload_encoders.h"
#include "pipeline/pack/zip_builder.h"
#include "runtime/atlas/scene.h"
#include "runtime/atlas/volume_payload.h"
#include "runtime/base/error.h"
#include "runtime/base/replace_file.h"
#include "runtime/base/sha256.h"

namespace beatlas::pack {
namespace {

class Items {
 public:
  Items(atlas::Manifest& manifest, std::vector<ZipEntry>& entries)
      : manifest_(manifest), entries_(entries) {}

  void add(std::string_view kind, Structure structure, atlas::Bytes bytes, int level = 0) {
    const std::string path = atlas::item_path(kind, structure, level);
    manifest_.items.push_back({path, std::string(kind), std::string(structure_name(structure)),
                               bytes.size(), sha256_hex(bytes), level});
    entries_.push_back({path, std::move(bytes)});
  }

 private:
  atlas::Manifest& manifest_;
  std::vector<ZipEntry>& entries_;
};

[[noreturn]] void refuse_two(std::string_view kind, Structure structure) {
  std::string message = "two payloads '";
  message += kind;
  message += "' of ";
  message += structure_name(structure);
  throw_invalid(message + " were given; give one");
}

template <class Payload>
int level_of(const Payload& payload) {
  if constexpr (requires { payload.level; }) return payload.level;
  return 0;
}

/// The payloads that `scene` holds, in the order of levels and kAllStructures so that the caller's
/// order leaves no trace in the package.
template <class Payload>
std::vector<const Payload*> held(const std::vector<Payload>& payloads, std::string_view scene,
                                 std::string_view kind) {
  std::vector<const Payload*> chosen;
  for (Structure structure : kAllStructures) {
    for (const Payload& payload : payloads) {
      if (payload.structure != structure) continue;
      if (atlas::scene_holds(scene, kind, structure)) chosen.push_back(&payload);
    }
  }
  std::stable_sort(chosen.begin(), chosen.end(),
                   [](const Payload* a, const Payload* b) { return level_of(*a) < level_of(*b); });
  const auto two =
      std::adjacent_find(chosen.begin(), chosen.end(), [](const Payload* a, const Payload* b) {
        return a->structure == b->structure && level_of(*a) == level_of(*b);
      });
  if (two != chosen.end()) refuse_two(kind, (*two)->structure);
  return chosen;
}

/// A coarser level is of a structure that has level 0, too.
void require_levels(const std::vector<const atlas::SurfacePayload*>& surfaces,
                    const atlas::Manifest& manifest) {
  for (const atlas::SurfacePayload* surface : surfaces) {
    const bool named =
        surface->level == 0 ||
        (surface->level > 0 && surface->level < static_cast<int>(manifest.surface_edges_mm.size()));
    const bool has_finest =
        std::any_of(surfaces.begin(), surfaces.end(), [&](const atlas::SurfacePayload* other) {
          return other->level == 0 && other->structure == surface->structure;
        });
    if (!named || !has_finest) {
      throw_invalid("level " + std::to_string(surface->level) + " of " +
                    std::string(structure_name(surface->structure)) +
                    " has no edge in surface_edges_mm, or there is no level 0 of it");
    }
  }
}

void require_phases(const atlas::Manifest& manifest, Structure structure, std::size_t phases) {
  if (static_cast<int>(phases) != manifest.phase_count()) {
    throw_invalid("a payload of " + std::string(structure_name(structure)) + " has " +
                  std::to_string(phases) + " phases, the volume curves have " +
                  std::to_string(manifest.phase_count()) + "; give one cycle");
  }
}

atlas::Bytes to_bytes(const std::string& text) {
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

}  // namespace

void write_package(const std::filesystem::path& file, const PackageContent& content,
                   const EncodeOptions& options,
                   const std::function<void(const std::filesystem::path&)>& look) {
  atlas::Manifest manifest = content.manifest;
  manifest.format_version = atlas::kFormatVersion;
  manifest.items.clear();
  // Refuses what the reader would refuse, before the costly part.
  (void)atlas::manifest_from_json(atlas::manifest_to_json(manifest));

  std::vector<ZipEntry> entries(1);
  Items items(manifest, entries);
  const auto fields = held(content.fields, manifest.scene, atlas::kFieldKind);
  for (const atlas::FieldPayload* field : fields) {
    require_phases(manifest, field->structure, static_cast<std::size_t>(field->phases));
  }
  const auto maps = held(content.maps, manifest.scene, atlas::kMapKind);
  const auto surfaces = held(content.surfaces, manifest.scene, atlas::kSurfaceKind);
  require_levels(surfaces, manifest);
  for (const atlas::SurfacePayload* surface : surfaces) {
    require_phases(manifest, surface->structure, surface->positions.size());
  }
  // Several at a time: parts of the work on one are a single thread's.
  std::vector<atlas::Bytes> packed_fields(fields.size());
  std::vector<PackedSurface> packed_surfaces(surfaces.size());
  parallel_for(fields.size() + surfaces.size(), [&](std::size_t n) {
    if (n < fields.size()) {
      const atlas::FieldPayload& field = *fields[n];
      packed_fields[n] = pack_field(field, field_step_mm(field.structure, options));
    } else {
      const std::size_t at = n - fields.size();
      packed_surfaces[at] = pack_surface(*surfaces[at], options.surface_step_mm);
    }
  });
  for (std::size_t n = 0; n < fields.size(); ++n) {
    items.add(atlas::kFieldKind, fields[n]->structure, std::move(packed_fields[n]));
  }
  for (std::size_t n = 0; n < surfaces.size(); ++n) {
    const atlas::SurfacePayload* surface = surfaces[n];
    PackedSurface& packed = packed_surfaces[n];
    items.add(atlas::kSurfaceKind, surface->structure, std::move(packed.drc), surface->level);
    items.add(atlas::kMotionKind, surface->structure, std::move(packed.motion), surface->level);
    for (const atlas::SurfaceMapPayload* map : maps) {
      if (map->structure != surface->structure || map->level != surface->level) continue;
      require_phases(manifest, map->structure, map->thickness_mm.size());
      items.add(atlas::kMapKind, map->structure, pack_surface_map(*map, packed.given),
                surface->level);
    }
  }
  if (content.volume && atlas::scene_holds(manifest.scene, atlas::kVolumeKind, Structure::Heart)) {
    const atlas::VolumePayload volume = atlas::decode_volume(content.volume->entry);
    require_phases(manifest, Structure::Heart, static_cast<std::size_t>(volume.phases));
    items.add(atlas::kVolumeKind, Structure::Heart, content.volume->entry);
  }
  const std::string text = atlas::manifest_to_json(manifest).dump(
                               2, ' ', false, nlohmann::json::error_handler_t::replace) +
                           "\n";
  (void)atlas::manifest_from_text(text);
  entries.front() = {std::string(atlas::kManifestEntry), to_bytes(text)};
  replace_file(file, build_zip(entries), look);
}

}  // namespace beatlas::pack
