#include "pipeline/ingest/padded_file.h"

#include <array>
#include <fstream>

#include <sys/mman.h>
#include <unistd.h>

namespace beatlas::ingest {

PaddedFile::PaddedFile(const std::filesystem::path& file)
    : descriptor_(memfd_create("padded", MFD_CLOEXEC)) {
  if (descriptor_ < 0) return;
  std::ifstream in(file, std::ios::binary);
  std::array<char, 1 << 16> piece;
  const auto put = [&](std::size_t count) {
    for (std::size_t done = 0; done < count;) {
      const ssize_t written = ::write(descriptor_, piece.data() + done, count - done);
      if (written <= 0) return false;
      done += static_cast<std::size_t>(written);
    }
    return true;
  };
  while (in) {
    in.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    if (!put(static_cast<std::size_t>(in.gcount()))) return;
  }
  constexpr std::size_t kZeros = 1 << 12;
  piece.fill(0);
  if (put(kZeros)) path_ = "/proc/self/fd/" + std::to_string(descriptor_);
}

PaddedFile::~PaddedFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace beatlas::ingest
