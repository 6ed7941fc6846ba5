#include "pipeline/report/base64.h"

namespace beatlas::report {

std::string base64(std::span<const std::uint8_t> bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    std::uint32_t word = std::uint32_t(bytes[at]) << 16;
    if (at + 1 < bytes.size()) word |= std::uint32_t(bytes[at + 1]) << 8;
    if (at + 2 < bytes.size()) word |= bytes[at + 2];
    out += kDigits[word >> 18];
    out += kDigits[(word >> 12) & 63];
    out += at + 1 < bytes.size() ? kDigits[(word >> 6) & 63] : '=';
    out += at + 2 < bytes.size() ? kDigits[word & 63] : '=';
  }
  return out;
}

}  // namespace beatlas::report
