#include <span>

#include "pipeline/formats/nifti.h"
#include "pipeline/formats/nifti_header.h"
#include "tests/fuzz/image_target.h"

namespace beatlas::fuzz {
std::vector<std::string> seeds() {
  const test::Beating object = tiny_object();
  std::vector<std::string> out;
  for (const int version : {1, 2}) {
    for (const bool big_endian : {false, true}) {
      const char* type = big_endian ? "f4" : "i2";
      out.push_back(
          test::nifti_header(object.grid, 3,
                             {.version = version, .big_endian = big_endian, .type = type}) +
          test::stored(object.voxels(), type, big_endian));
    }
  }
  out.push_back(test::gzip(out[0]));
  return out;
}
std::vector<std::string> tokens() { return {"n+1", "ni1", "n+2", std::string(4, '\0')}; }
}  // namespace beatlas::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace beatlas;
  fuzz::only_errors([&] {
    const auto fields = formats::parse_nifti_header(std::as_bytes(std::span(data, size)));
    (void)formats::frames_of(fields);
    std::string note;
    (void)formats::lps_from_index(formats::geometry_of(fields), note);
  });
  static const fuzz::MemoryFolder folder;
  const auto file = folder.write("a.nii", fuzz::text(data, size));
  fuzz::read_image(file);
  fuzz::only_errors([&] { (void)formats::read_nifti_labels(file); });
  return 0;
}
