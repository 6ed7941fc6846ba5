#pragma once
/// Files of the transfer syntax "deflated": readable as plain ones.

#include <filesystem>
#include <string>

namespace beatlas::ingest {

/// A DICOM file whose data set is inflated, in memory; the system sees it as a file.
class InflatedFile {
 public:
  /// `good()` is false if the file is not deflated DICOM, is damaged, or holds more than its size
  /// makes plausible (runtime/base/plausible_size.h): then inflating ended there.
  explicit InflatedFile(const std::filesystem::path& file);
  ~InflatedFile();
  InflatedFile(const InflatedFile&) = delete;
  InflatedFile& operator=(const InflatedFile&) = delete;

  [[nodiscard]] bool good() const { return descriptor_ >= 0; }
  /// Whether it would hold more than is plausible.
  [[nodiscard]] bool too_large() const { return too_large_; }
  /// Where other readers find it, as long as this object lives.
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  int descriptor_ = -1;
  bool too_large_ = false;
  std::string path_;
};

}  // namespace beatlas::ingest
