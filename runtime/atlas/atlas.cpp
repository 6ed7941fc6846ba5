#include "runtime/atlas/atlas.h"

#include "runtime/atlas/field_payload.h"
#include "runtime/atlas/scene.h"
#include "runtime/atlas/surface_map_payload.h"
#include "runtime/atlas/surface_payload.h"
#include "runtime/atlas/volume_payload.h"
#include "runtime/atlas/zip_archive.h"
#include "runtime/base/error.h"
#include "runtime/base/sha256.h"

namespace beatlas::atlas {
namespace {

constexpr std::uint64_t kMaxManifestBytes = std::uint64_t{16} << 20;

Manifest read_manifest(const ZipArchive& archive) {
  if (archive.entries().empty() || archive.entries().front().name != kManifestEntry) {
    throw_invalid("does not begin with atlas.json; this is no package");
  }
  if (archive.entries().front().bytes > kMaxManifestBytes) {
    throw_invalid("atlas.json is larger than 16 MiB; this is no package");
  }
  const Bytes bytes = archive.read(0);
  return manifest_from_text({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

/// The manifest and the zip's directory must tell the same story.
void compare(const Manifest& manifest, const ZipArchive& archive) {
  for (const Item& item : manifest.items) {
    const auto index = archive.find(item.path);
    if (!index)
      throw_invalid("lacks entry '" + item.path + "', which atlas.json names; copy again");
    if (archive.entries()[*index].bytes != item.bytes) {
      throw_invalid("entry '" + item.path +
                    "' is not of the size that atlas.json says; copy again");
    }
  }
  for (const ZipArchive::Entry& entry : archive.entries()) {
    bool named = entry.name == kManifestEntry;
    for (const Item& item : manifest.items) named = named || item.path == entry.name;
    if (!named) {
      throw_invalid("holds entry '" + printable(entry.name) +
                    "', which atlas.json does not name; build the package again");
    }
  }
}

const Item* find_item(const Manifest& manifest, std::string_view kind, Structure structure,
                      int level) {
  for (const Item& item : manifest.items) {
    if (item.kind == kind && item.structure == structure_name(structure) && item.level == level) {
      return &item;
    }
  }
  return nullptr;
}

[[noreturn]] void refuse_missing(const Manifest& manifest, std::string_view kind,
                                 Structure structure) {
  const std::string name(structure_name(structure));
  std::string known;
  for (const StructureEntry& entry : manifest.structures) {
    if (entry.name == name) {
      const std::string what = "holds no " + std::string(kind) + " of " + name;
      if (scene_holds(manifest.scene, kind, structure)) {
        throw_invalid(what + " although its scene " + manifest.scene +
                      " would; its build made none, build it again");
      }
      const std::string scenes = scenes_that_hold(kind, structure);
      if (scenes.empty()) {
        throw_invalid(what + ", which no scene has; its surface is in --scene " +
                      scenes_that_hold(kSurfaceKind, structure));
      }
      throw_invalid(what + "; build it with --scene " + scenes);
    }
    known += (known.empty() ? "" : ", ") + entry.name;
  }
  if (!kind_exists(kind, structure)) {
    throw_invalid("holds no " + std::string(kind) + " of " + name + ", nor does any package");
  }
  throw_invalid("holds no " + std::string(kind) + " of " + name +
                ": its images gave no such structure, only " + known);
}

Bytes read_item(const Manifest& manifest, const ZipArchive& archive, std::string_view kind,
                Structure structure, int level = 0) {
  const Item* item = find_item(manifest, kind, structure, level);
  if (item == nullptr) refuse_missing(manifest, kind, structure);
  Bytes bytes = archive.read(*archive.find(item->path));
  if (sha256_hex(bytes) != item->sha256) {
    throw_invalid("entry '" + item->path +
                  "' has not the SHA-256 that atlas.json says; copy or build the package again");
  }
  return bytes;
}

void require_phases(const Manifest& manifest, std::size_t phases) {
  if (static_cast<int>(phases) != manifest.phase_count()) {
    throw_invalid("has another number of phases than atlas.json says; build the package again");
  }
}

std::shared_ptr<const FieldPayload> read_field(const Manifest& manifest, const ZipArchive& archive,
                                               Structure structure) {
  const Bytes bytes = read_item(manifest, archive, kFieldKind, structure);
  try {
    auto field = std::make_shared<FieldPayload>(decode_field(bytes, structure));
    require_phases(manifest, static_cast<std::size_t>(field->phases));
    return field;
  } catch (const Error& error) {
    throw error.with_context(item_path(kFieldKind, structure));
  }
}

std::shared_ptr<const SurfacePayload> read_surface(const Manifest& manifest,
                                                   const ZipArchive& archive, Structure structure,
                                                   int level) {
  const Bytes base = read_item(manifest, archive, kSurfaceKind, structure, level);
  const Bytes motion = read_item(manifest, archive, kMotionKind, structure, level);
  try {
    auto surface = std::make_shared<SurfacePayload>(decode_surface(base, motion, structure));
    surface->level = level;
    require_phases(manifest, surface->positions.size());
    return surface;
  } catch (const Error& error) {
    throw error.with_context(item_path(kSurfaceKind, structure, level));
  }
}

/// @param surface that it is a map of, if that was read too
std::shared_ptr<const SurfaceMapPayload> read_map(const Manifest& manifest,
                                                  const ZipArchive& archive, Structure structure,
                                                  int level, const SurfacePayload* surface) {
  const Bytes bytes = read_item(manifest, archive, kMapKind, structure, level);
  try {
    auto map = std::make_shared<SurfaceMapPayload>(decode_surface_map(bytes, structure));
    map->level = level;
    require_phases(manifest, map->thickness_mm.size());
    if (surface != nullptr && surface->positions.front().size() != map->segment.size()) {
      throw_invalid("has another number of vertices than the surface; build the package again");
    }
    return map;
  } catch (const Error& error) {
    throw error.with_context(item_path(kMapKind, structure, level));
  }
}

std::shared_ptr<const VolumePayload> read_volume(const Manifest& manifest,
                                                 const ZipArchive& archive) {
  const Bytes bytes = read_item(manifest, archive, kVolumeKind, Structure::Heart);
  try {
    auto volume = std::make_shared<VolumePayload>(decode_volume(bytes));
    require_phases(manifest, static_cast<std::size_t>(volume->phases));
    return volume;
  } catch (const Error& error) {
    throw error.with_context(item_path(kVolumeKind, Structure::Heart));
  }
}

template <class Payload>
std::shared_ptr<const Payload> find(const std::vector<std::shared_ptr<const Payload>>& payloads,
                                    Structure structure) {
  for (const auto& payload : payloads) {
    if (payload->structure == structure) return payload;
  }
  return nullptr;
}

template <class Payload>
std::shared_ptr<const Payload> find(const std::vector<std::shared_ptr<const Payload>>& payloads,
                                    Structure structure, int level) {
  for (const auto& payload : payloads) {
    if (payload->structure == structure && payload->level == level) return payload;
  }
  return nullptr;
}

}  // namespace

Needs everything_in(const Manifest& manifest) {
  Needs needs;
  for (const Item& item : manifest.items) {
    const auto structure = structure_from_name(item.structure);
    if (!structure) continue;
    if (item.level > 0) needs.levels.insert(item.level);
    if (item.kind == kVolumeKind) {
      needs.volume = true;
    } else if (item.kind == kMapKind) {
      needs.maps.insert(*structure);
    } else {
      (item.kind == kFieldKind ? needs.fields : needs.surfaces).insert(*structure);
    }
  }
  return needs;
}

Atlas Atlas::open(const std::filesystem::path& file, const Needs& needs) {
  try {
    const ZipArchive archive(file);
    Atlas atlas;
    atlas.manifest_ = read_manifest(archive);
    compare(atlas.manifest_, archive);
    for (Structure structure : needs.fields) {
      atlas.fields_.push_back(read_field(atlas.manifest_, archive, structure));
    }
    for (const int level : needs.levels) {
      const auto passed_over = [&](std::string_view kind, Structure structure) {
        return level > 0 && find_item(atlas.manifest_, kind, structure, level) == nullptr;
      };
      for (Structure structure : needs.surfaces) {
        if (passed_over(kSurfaceKind, structure)) continue;
        atlas.surfaces_.push_back(read_surface(atlas.manifest_, archive, structure, level));
      }
      for (Structure structure : needs.maps) {
        if (passed_over(kMapKind, structure)) continue;
        const auto surface = atlas.surface(structure, level);
        atlas.maps_.push_back(read_map(atlas.manifest_, archive, structure, level, surface.get()));
      }
    }
    if (needs.volume) atlas.volume_ = read_volume(atlas.manifest_, archive);
    return atlas;
  } catch (const Error& error) {
    throw error.with_context(file.string());
  }
}

std::shared_ptr<const FieldPayload> Atlas::field(Structure structure) const {
  return find(fields_, structure);
}

std::shared_ptr<const SurfacePayload> Atlas::surface(Structure structure, int level) const {
  return find(surfaces_, structure, level);
}

std::shared_ptr<const SurfaceMapPayload> Atlas::surface_map(Structure structure, int level) const {
  return find(maps_, structure, level);
}

}  // namespace beatlas::atlas
