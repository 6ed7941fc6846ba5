#pragma once
/// The reader. Trusts nothing: sizes, hashes and every index are checked before use.

#include <filesystem>
#include <memory>
#include <set>
#include <vector>

#include "runtime/atlas/manifest.h"
#include "runtime/atlas/payloads.h"

namespace beatlas::atlas {

/// What a program will use; everything else stays on disk. What is needed later, as the volume when
/// it is drawn for the first time, is had by opening the package once more, in another thread if it
/// must not wait.
struct Needs {
  std::set<Structure> fields;
  std::set<Structure> surfaces;
  bool volume = false;
  std::set<Structure> maps = {};
  /// Levels of detail of `surfaces` and `maps`, 0 the finest; see Manifest::surface_edges_mm. What
  /// is not there at a level above 0 is passed over.
  std::set<int> levels = {0};
};

/// Every payload that `manifest` names.
[[nodiscard]] Needs everything_in(const Manifest& manifest);

/// An opened package; immutable, so it may be shared between threads.
class Atlas {
 public:
  /// Reads the manifest and the payloads in `needs`. Entries of the zip that the manifest does not
  /// name, or of another size than it says, are refused whether needed or not; hashes are checked
  /// of what is read.
  /// @throws Error{InvalidInput} if the file is no package, damaged, of a future format, or lacks
  /// a needed payload (the message names it and the scene that would hold it).
  [[nodiscard]] static Atlas open(const std::filesystem::path& file, const Needs& needs);

  [[nodiscard]] const Manifest& manifest() const { return manifest_; }
  /// Null if it was not asked for.
  [[nodiscard]] std::shared_ptr<const FieldPayload> field(Structure structure) const;
  [[nodiscard]] std::shared_ptr<const SurfacePayload> surface(Structure structure,
                                                              int level = 0) const;
  /// Its vertices are those of surface(structure, level), in that order.
  [[nodiscard]] std::shared_ptr<const SurfaceMapPayload> surface_map(Structure structure,
                                                                     int level = 0) const;
  [[nodiscard]] std::shared_ptr<const VolumePayload> volume() const { return volume_; }

 private:
  Manifest manifest_;
  std::vector<std::shared_ptr<const FieldPayload>> fields_;
  std::vector<std::shared_ptr<const SurfacePayload>> surfaces_;
  std::vector<std::shared_ptr<const SurfaceMapPayload>> maps_;
  std::shared_ptr<const VolumePayload> volume_;
};

}  // namespace beatlas::atlas
