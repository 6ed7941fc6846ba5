#pragma once
#include <filesystem>
#include <string>

namespace beatlas::ingest {

/// A file with zeros behind it, in memory; the system sees it as a file. vtk-dicom reads on behind
/// the end of a file that is cut within the head of an element, and by what it finds there it goes
/// on to where no memory is: it is given zeros to find.
class PaddedFile {
 public:
  explicit PaddedFile(const std::filesystem::path& file);
  ~PaddedFile();
  PaddedFile(const PaddedFile&) = delete;
  PaddedFile& operator=(const PaddedFile&) = delete;

  /// Where other readers find it, as long as this object lives; empty if there is no memory for it.
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  int descriptor_ = -1;
  std::string path_;
};

}  // namespace beatlas::ingest
