#include "tests/fuzz/image_target.h"

namespace beatlas::fuzz {
std::vector<std::string> seeds() {
  const test::Beating object = tiny_object();
  const auto voxels = test::stored(object.voxels(), "i2");
  const auto head = test::meta_header(object.grid, 3);
  return {head + "ElementDataFile = LOCAL\n" + voxels,
          head + "CompressedData = True\nElementDataFile = LOCAL\n" + test::zlib(voxels),
          test::meta_header(object.grid, 1) + "BinaryData = False\nElementDataFile = LOCAL\n" +
              test::stored(object.voxels(), "text"),
          head + "HeaderSize = -1\nElementDataFile = a.mha\n",
          head + "ElementDataFile = LIST\na.mha\na.mha\n"};
}
std::vector<std::string> tokens() {
  return {"NDims = ",
          "DimSize = ",
          "HeaderSize = ",
          "ElementNumberOfChannels = 3\n",
          "MET_DOUBLE",
          "ElementDataFile = a%d.raw 1 9 1\n",
          "\n",
          " = ",
          "DistanceUnits = m\n",
          "ElementToIntensityFunctionSlope = 1e300\n",
          "Orientation = ",
          "BinaryDataByteOrderMSB = "};
}
}  // namespace beatlas::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace beatlas;
  static const fuzz::MemoryFolder folder;
  fuzz::read_image(folder.write("a.mha", fuzz::text(data, size)));
  return 0;
}
