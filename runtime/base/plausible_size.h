#pragma once
/// How much packed bytes are believed to hold. Whoever reads a file takes memory by this rule and
/// not by what its header claims: a small file must not fill the machine, whoever wrote it.
///
/// What the formats themselves could reach is no guard. Deflate (RFC 1951) codes a match of at
/// most 258 bytes in at least 2 bits, hence 1032 : 1. bzip2 first writes runs of up to 259 equal
/// bytes as 5, so that a block of 900 kB stands for 46 MB, and packs such a block into some 40
/// bytes: about 1 000 000 : 1. zstd and the run modes of JPEG-LS and JPEG 2000 know no bound.
/// The limits below stand well above what sound files hold instead; unpacked data are believed to
/// any size, because the bytes are there.

#include <algorithm>
#include <cstdint>
#include <string>

namespace beatlas {

struct UnpackLimits {
  std::uint64_t ratio;  ///< believed bytes to a packed byte
  std::uint64_t floor;  ///< bytes believed whatever the packed size
  std::uint64_t most;   ///< bytes, of one file or payload
};

/// Images: bytes of the voxels in memory. MR images pack 2 to 5 : 1 and shares of voxels, mostly
/// zeros, about 90 : 1. The most have images of flat regions without noise, as labels and some
/// phantoms are: on voxels of 1 mm gzip packs bytes 97 : 1, and read as floats they take four times
/// as much. A cine of 512 x 512 x 100 voxels and 40 phases takes 4 GiB.
inline constexpr UnpackLimits kImageUnpack{
    .ratio = 400, .floor = std::uint64_t{64} << 20, .most = std::uint64_t{16} << 30};

/// Payloads of a package: a static field of 30 phases packs about 100 : 1, of 200 phases more.
inline constexpr UnpackLimits kPayloadUnpack{
    .ratio = 1000, .floor = std::uint64_t{1} << 20, .most = std::uint64_t{1} << 30};

/// The most that `packed` bytes are believed to stand for.
[[nodiscard]] constexpr std::uint64_t plausible_bytes(std::uint64_t packed,
                                                      const UnpackLimits& limits) noexcept {
  const std::uint64_t times = std::min(packed, limits.most / limits.ratio);  // does not overflow
  return std::min(limits.most, limits.floor + limits.ratio * times);
}

/// "0.5 MB", for messages.
[[nodiscard]] inline std::string in_megabytes(std::uint64_t bytes) {
  constexpr std::uint64_t kTenth = 100'000;
  const std::uint64_t tenths = (bytes + kTenth - 1) / kTenth;
  return std::to_string(tenths / 10) + '.' + std::to_string(tenths % 10) + " MB";
}

}  // namespace beatlas
