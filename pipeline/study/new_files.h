#pragma once
/// Several files that come into a folder together, and take nobody's place.

#include <filesystem>

namespace beatlas::study {

/// They are written into a hidden folder within `folder` and moved from there once all are whole.
/// If anything fails before, the hidden folder goes, and so does `folder` if it was made for them.
class NewFiles {
 public:
  /// @throws Error{Machine} if the folder cannot be made or written
  explicit NewFiles(std::filesystem::path folder);
  ~NewFiles();
  NewFiles(const NewFiles&) = delete;
  NewFiles& operator=(const NewFiles&) = delete;

  /// Where to write them.
  [[nodiscard]] const std::filesystem::path& place() const { return place_; }

  /// Moves them into the folder. One that is there already with the same bytes is left as it is.
  /// @throws Error{Usage} naming what is there otherwise, a link too; Error{Machine}; then none is
  /// moved
  void put();

 private:
  std::filesystem::path folder_;
  std::filesystem::path place_;
  bool made_ = false;
};

}  // namespace beatlas::study
