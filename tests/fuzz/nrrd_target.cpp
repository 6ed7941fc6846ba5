#include "tests/fuzz/image_target.h"

namespace beatlas::fuzz {
std::vector<std::string> seeds() {
  const test::Beating object = tiny_object();
  const auto voxels = test::stored(object.voxels(), "i2");
  const auto head = [&](bool first, const std::string& space = "left-posterior-superior") {
    return test::nrrd_header(object.grid, 3, first, space);
  };
  return {head(false) + "encoding: raw\n\n" + voxels,
          head(true, "RAS") +
              "labels: \"time\" \"\" \"\" \"\"\nunits: \"ms\" \"\" \"\" \"\"\nkinds: list domain "
              "domain domain\naxis 0 index values:=0 300 600\nencoding: gzip\n\n" +
              test::gzip(voxels),
          head(false) + "encoding: bzip2\n\n" + test::bzip2(voxels),
          head(false) + "line skip: 1\nbyte skip: 2\nencoding: ascii\n\nx\nab" +
              test::stored(object.voxels(), "text"),
          head(false) + "byteskip: -1\nencoding: raw\n\n" + voxels,
          head(false) + "encoding: raw\ndata file: LIST\na.nrrd\na.nrrd\n",
          "NRRD0001\ntype: uchar\ndimension: 3\nsizes: 1 2 3\nspacings: 1 2 3\nencoding: "
          "raw\n\nabcdef"};
}
std::vector<std::string> tokens() {
  return {"sizes: ",
          "\nbyte skip: ",
          "\nline skip: ",
          "none",
          "(1,0,0)",
          "(0,0,0,1)",
          "\nspace: left-posterior-superior-time",
          "\ndata file: a%03d.raw 1 9 1\n",
          "\ndata file: LIST\n",
          ":=",
          "\nkinds: vector domain domain domain\n",
          "\n\n",
          "\"",
          "\nspace units: \"m\" \"m\" \"m\"\n",
          "\nspacings: nan 1 1 1\n",
          "dimension: 16\n",
          "MultiVolume.FrameIdentifyingDICOMTagName:=TriggerTime\n"};
}
}  // namespace beatlas::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace beatlas;
  static const fuzz::MemoryFolder folder;
  fuzz::read_image(folder.write("a.nrrd", fuzz::text(data, size)));
  return 0;
}
