#include "pipeline/pack/zip_builder.h"

#include <memory>

#include <zip.h>

#include "runtime/base/error.h"

namespace beatlas::pack {
namespace {

void require(bool ok) {
  if (!ok) throw Error(ErrorCode::Machine, "the package cannot be put together; free some memory");
}

struct FreeSource {
  void operator()(zip_source_t* source) const noexcept { zip_source_free(source); }
};
using Source = std::unique_ptr<zip_source_t, FreeSource>;

struct DiscardArchive {
  void operator()(zip_t* archive) const noexcept { zip_discard(archive); }
};

void add(zip_t* archive, const ZipEntry& entry) {
  constexpr zip_uint16_t kMidnight = 0;
  constexpr zip_uint16_t kFirstOfJanuary1980 = (1U << 5U) | 1U;
  Source source(zip_source_buffer(archive, entry.bytes.data(), entry.bytes.size(), 0));
  require(source != nullptr);
  const zip_int64_t index =
      zip_file_add(archive, entry.name.c_str(), source.get(), ZIP_FL_ENC_UTF_8);
  require(index >= 0);
  (void)source.release();  // the archive's now
  const auto at = static_cast<zip_uint64_t>(index);
  require(zip_set_file_compression(archive, at, ZIP_CM_STORE, 0) == 0);
  require(zip_file_set_dostime(archive, at, kMidnight, kFirstOfJanuary1980, 0) == 0);
}

}  // namespace

atlas::Bytes build_zip(const std::vector<ZipEntry>& entries) {
  zip_error_t error;
  zip_error_init(&error);
  Source buffer(zip_source_buffer_create(nullptr, 0, 0, &error));
  require(buffer != nullptr);
  zip_source_keep(buffer.get());  // once for the archive, once to read it afterwards
  std::unique_ptr<zip_t, DiscardArchive> archive(
      zip_open_from_source(buffer.get(), ZIP_CREATE | ZIP_TRUNCATE, &error));
  if (!archive) {
    zip_source_free(buffer.get());
    require(false);
  }
  for (const ZipEntry& entry : entries) add(archive.get(), entry);
  require(zip_close(archive.get()) == 0);
  (void)archive.release();

  require(zip_source_open(buffer.get()) == 0);
  zip_stat_t status;
  require(zip_source_stat(buffer.get(), &status) == 0 && (status.valid & ZIP_STAT_SIZE) != 0);
  atlas::Bytes bytes(static_cast<std::size_t>(status.size));
  const zip_int64_t got = zip_source_read(buffer.get(), bytes.data(), bytes.size());
  zip_source_close(buffer.get());
  require(got >= 0 && static_cast<std::size_t>(got) == bytes.size());
  return bytes;
}

}  // namespace beatlas::pack
