#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runtime/atlas/bytes.h"

namespace beatlas::atlas {

/// A zip whose entries are stored, not compressed, so that nothing in it can be larger than the
/// file. Move-only; one thread at a time.
class ZipArchive {
 public:
  struct Entry {
    std::string name;         ///< raw bytes of the name: for lookups, see printable()
    std::uint64_t bytes = 0;  ///< what the directory says; <= size of the file
  };

  /// Reads the directory.
  /// @throws Error{InvalidInput} if `file` cannot be read, is no zip, is damaged or cut short, has
  /// more than kMaxEntries, a name twice, or an entry that is compressed or encrypted.
  explicit ZipArchive(const std::filesystem::path& file);
  ~ZipArchive();
  ZipArchive(ZipArchive&&) noexcept;
  ZipArchive& operator=(ZipArchive&&) noexcept;

  static constexpr std::size_t kMaxEntries = 1024;

  /// In the order of the directory.
  [[nodiscard]] const std::vector<Entry>& entries() const noexcept { return entries_; }
  [[nodiscard]] std::optional<std::size_t> find(std::string_view name) const noexcept;
  /// The whole entry; its checksum has been verified. @throws Error{InvalidInput}
  [[nodiscard]] Bytes read(std::size_t index) const;

 private:
  struct Close {
    void operator()(void* archive) const noexcept;
  };
  std::unique_ptr<void, Close> archive_;
  std::vector<Entry> entries_;
};

/// `name` with what could disturb a terminal replaced by '?', at most 80 characters.
[[nodiscard]] std::string printable(std::string_view name);

}  // namespace beatlas::atlas
