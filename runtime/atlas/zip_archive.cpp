#include "runtime/atlas/zip_archive.h"

#include <algorithm>
#include <fstream>
#include <set>

#include <zip.h>

namespace beatlas::atlas {
namespace {

constexpr std::size_t kEndRecordBytes = 22;
constexpr std::size_t kZip64LocatorBytes = 20;
constexpr std::size_t kMaxCommentBytes = 65535;

/// libzip believes the entry count of a zip64 directory before it has seen an entry and allocates
/// for it. A package needs no zip64, so an end record with a zip64 locator before it is refused.
void refuse_zip64(const std::filesystem::path& file, std::uint64_t file_bytes) {
  const std::size_t tail_bytes = static_cast<std::size_t>(
      std::min<std::uint64_t>(file_bytes, kEndRecordBytes + kMaxCommentBytes + kZip64LocatorBytes));
  std::string tail(tail_bytes, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.seekg(-static_cast<std::streamoff>(tail_bytes), std::ios::end);
  stream.read(tail.data(), static_cast<std::streamsize>(tail_bytes));
  if (!stream) throw_invalid("cannot be read; check the disk and its permissions");
  using namespace std::string_view_literals;
  for (std::size_t at = tail.find("PK\x06\x07"sv); at != std::string::npos;
       at = tail.find("PK\x06\x07"sv, at + 1)) {
    if (tail.compare(std::min(tail.size(), at + kZip64LocatorBytes), 4, "PK\x05\x06"sv) == 0) {
      throw_invalid("is a zip64 archive, which no package is; build the package again");
    }
  }
}

zip_t* handle(const auto& archive) { return static_cast<zip_t*>(archive.get()); }

}  // namespace

void ZipArchive::Close::operator()(void* archive) const noexcept {
  zip_discard(static_cast<zip_t*>(archive));
}
ZipArchive::~ZipArchive() = default;
ZipArchive::ZipArchive(ZipArchive&&) noexcept = default;
ZipArchive& ZipArchive::operator=(ZipArchive&&) noexcept = default;

ZipArchive::ZipArchive(const std::filesystem::path& file) {
  std::error_code status;
  if (!std::filesystem::exists(file, status)) throw_invalid("does not exist; check the name");
  if (!std::filesystem::is_regular_file(file, status)) throw_invalid("is not a file");
  const std::uint64_t file_bytes = std::filesystem::file_size(file, status);
  if (status) throw_invalid("cannot be read; check its permissions");
  const char* damaged = "is no package, or damaged or cut short; copy or build it again";
  if (file_bytes < kEndRecordBytes) throw_invalid(damaged);
  refuse_zip64(file, file_bytes);

  int code = 0;
  archive_.reset(zip_open(file.c_str(), ZIP_RDONLY | ZIP_CHECKCONS, &code));
  if (!archive_) {
    if (code == ZIP_ER_OPEN || code == ZIP_ER_READ) {
      throw_invalid("cannot be read; check its permissions");
    }
    throw_invalid(damaged);
  }
  const zip_int64_t count = zip_get_num_entries(handle(archive_), 0);
  if (count < 0 || static_cast<std::size_t>(count) > kMaxEntries) {
    throw_invalid("holds more than " + std::to_string(kMaxEntries) +
                  " entries; this is no package");
  }
  std::set<std::string> names;
  for (zip_uint64_t i = 0; i < static_cast<zip_uint64_t>(count); ++i) {
    zip_stat_t entry;
    constexpr zip_uint64_t kKnown = ZIP_STAT_NAME | ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE |
                                    ZIP_STAT_COMP_METHOD | ZIP_STAT_ENCRYPTION_METHOD;
    if (zip_stat_index(handle(archive_), i, ZIP_FL_ENC_RAW, &entry) != 0 ||
        (entry.valid & kKnown) != kKnown) {
      throw_invalid(damaged);
    }
    const std::string name = entry.name;
    if (entry.comp_method != ZIP_CM_STORE || entry.encryption_method != ZIP_EM_NONE ||
        entry.size != entry.comp_size || entry.size > file_bytes) {
      throw_invalid("entry '" + printable(name) +
                    "' is compressed, encrypted or of a wrong size; a package stores its entries "
                    "as they are (zip -0)");
    }
    if (!names.insert(name).second) {
      throw_invalid("holds entry '" + printable(name) + "' twice; build the package again");
    }
    entries_.push_back({name, entry.size});
  }
}

std::optional<std::size_t> ZipArchive::find(std::string_view name) const noexcept {
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (entries_[i].name == name) return i;
  }
  return std::nullopt;
}

Bytes ZipArchive::read(std::size_t index) const {
  const Entry& entry = entries_.at(index);
  const auto fail = [&entry] {
    throw_invalid("entry '" + printable(entry.name) +
                  "' is damaged (its checksum or size is wrong); copy or build the package again");
  };
  const auto close = [](zip_file_t* stream) { zip_fclose(stream); };
  std::unique_ptr<zip_file_t, decltype(close)> stream(zip_fopen_index(handle(archive_), index, 0),
                                                      close);
  if (!stream) fail();
  Bytes bytes(static_cast<std::size_t>(entry.bytes));
  std::size_t done = 0;
  while (done < bytes.size()) {
    const zip_int64_t got = zip_fread(stream.get(), bytes.data() + done, bytes.size() - done);
    if (got <= 0) fail();
    done += static_cast<std::size_t>(got);
  }
  // libzip compares the checksum when it meets the end.
  char beyond = 0;
  if (zip_fread(stream.get(), &beyond, 1) != 0) fail();
  return bytes;
}

std::string printable(std::string_view name) {
  constexpr std::size_t kMaxLength = 80;
  std::string text(name.substr(0, kMaxLength));
  for (char& c : text) {
    if (c < ' ' || c > '~') c = '?';
  }
  if (name.size() > kMaxLength) text += "...";
  return text;
}

}  // namespace beatlas::atlas
