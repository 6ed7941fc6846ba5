#include "pipeline/formats/byte_source.h"

#include <array>
#include <cstdio>

#include <bzlib.h>
#include <zlib.h>

#include "runtime/base/error.h"

namespace beatlas::formats {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBuffer = std::size_t{1} << 16;
constexpr const char* kDamaged = "its packed data are damaged; copy or export it again";

struct Close {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

class RawSource final : public ByteSource {
 public:
  RawSource(const fs::path& file, std::int64_t offset) : file_(std::fopen(file.c_str(), "rb")) {
    if (!file_ || std::fseek(file_.get(), static_cast<long>(offset), SEEK_SET) != 0) {
      throw_invalid("its data cannot be read");
    }
  }
  std::size_t read(std::byte* bytes, std::size_t count) override {
    const std::size_t got = std::fread(bytes, 1, count, file_.get());
    if (got < count && std::ferror(file_.get()) != 0) {
      throw_invalid("its data cannot be read to their end");
    }
    return got;
  }

 private:
  std::unique_ptr<std::FILE, Close> file_;
};

/// Packed bytes of a file, in pieces.
class Packed {
 public:
  Packed(const fs::path& file, std::int64_t offset) : raw_(file, offset) {}
  /// The next piece, empty at the end of the file.
  std::size_t refill() { return raw_.read(buffer_.data(), buffer_.size()); }
  [[nodiscard]] std::byte* data() { return buffer_.data(); }

 private:
  RawSource raw_;
  std::array<std::byte, kBuffer> buffer_{};
};

class DeflateSource final : public ByteSource {
 public:
  DeflateSource(const fs::path& file, std::int64_t offset) : packed_(file, offset) {
    constexpr int kGzipOrZlib = 15 + 32;
    if (inflateInit2(&stream_, kGzipOrZlib) != Z_OK) {
      throw Error(ErrorCode::Machine, "out of memory");
    }
  }
  ~DeflateSource() override { inflateEnd(&stream_); }

  std::size_t read(std::byte* bytes, std::size_t count) override {
    std::size_t done = 0;
    while (done < count && !at_end_) {
      if (stream_.avail_in == 0) {
        stream_.avail_in = static_cast<uInt>(packed_.refill());
        stream_.next_in = reinterpret_cast<Bytef*>(packed_.data());
        if (stream_.avail_in == 0) break;
      }
      const auto room = static_cast<uInt>(std::min(count - done, kBuffer));
      stream_.next_out = reinterpret_cast<Bytef*>(bytes + done);
      stream_.avail_out = room;
      const int state = inflate(&stream_, Z_NO_FLUSH);
      done += room - stream_.avail_out;
      if (state == Z_STREAM_END) {
        next_member();
      } else if (state != Z_OK && state != Z_BUF_ERROR) {
        throw_invalid(kDamaged);
      }
    }
    return done;
  }

 private:
  /// gzip files may be several, one after the other; anything else behind the first is padding.
  void next_member() {
    if (stream_.avail_in == 0) {
      stream_.avail_in = static_cast<uInt>(packed_.refill());
      stream_.next_in = reinterpret_cast<Bytef*>(packed_.data());
    }
    at_end_ = stream_.avail_in < 2 || stream_.next_in[0] != 0x1f || stream_.next_in[1] != 0x8b;
    if (!at_end_) inflateReset(&stream_);
  }
  Packed packed_;
  z_stream stream_{};
  bool at_end_ = false;
};

class Bzip2Source final : public ByteSource {
 public:
  Bzip2Source(const fs::path& file, std::int64_t offset) : packed_(file, offset) {
    if (BZ2_bzDecompressInit(&stream_, 0, 0) != BZ_OK) {
      throw Error(ErrorCode::Machine, "out of memory");
    }
  }
  ~Bzip2Source() override { BZ2_bzDecompressEnd(&stream_); }

  std::size_t read(std::byte* bytes, std::size_t count) override {
    std::size_t done = 0;
    while (done < count && !at_end_) {
      if (stream_.avail_in == 0) {
        stream_.avail_in = static_cast<unsigned>(packed_.refill());
        stream_.next_in = reinterpret_cast<char*>(packed_.data());
        if (stream_.avail_in == 0) break;
      }
      const auto room = static_cast<unsigned>(std::min(count - done, kBuffer));
      stream_.next_out = reinterpret_cast<char*>(bytes + done);
      stream_.avail_out = room;
      const int state = BZ2_bzDecompress(&stream_);
      done += room - stream_.avail_out;
      if (state == BZ_STREAM_END) {
        at_end_ = true;
      } else if (state != BZ_OK) {
        throw_invalid(kDamaged);
      }
    }
    return done;
  }

 private:
  Packed packed_;
  bz_stream stream_{};
  bool at_end_ = false;
};

}  // namespace

std::unique_ptr<ByteSource> open_bytes(const fs::path& file, std::int64_t offset, Packing packing) {
  switch (packing) {
    case Packing::Raw:
    case Packing::Text:
      return std::make_unique<RawSource>(file, offset);
    case Packing::Deflate:
      return std::make_unique<DeflateSource>(file, offset);
    case Packing::Bzip2:
      return std::make_unique<Bzip2Source>(file, offset);
  }
  throw_invalid("its packing is not known");
}

std::int64_t size_of_file(const fs::path& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) throw_invalid("no such file");
  const auto size = fs::file_size(file, error);
  if (error) throw_invalid("it cannot be read");
  return static_cast<std::int64_t>(size);
}

bool is_gzip(const fs::path& file) {
  std::array<std::byte, 2> start{};
  return RawSource(file, 0).read(start.data(), start.size()) == start.size() &&
         start[0] == std::byte{0x1f} && start[1] == std::byte{0x8b};
}

}  // namespace beatlas::formats
