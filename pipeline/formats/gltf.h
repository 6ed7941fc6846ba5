#pragma once
/// glTF 2.0 out, binary form (.glb): surfaces of the cycle that a stock viewer plays.

#include <memory>
#include <vector>

#include "runtime/atlas/bytes.h"
#include "runtime/atlas/payloads.h"
#include "runtime/base/geometry.h"

namespace beatlas::formats {

struct GltfPlacement {
  Affine workspace_from_lps = Affine::Identity();  ///< rigid
  double rr_interval_s = 1;                        ///< [s] > 0: length of the animation
};

/// One node and mesh a structure, named after it, with a material of its own. The first phase is
/// the mesh; every other phase is a morph target (of positions and normals), and the animation
/// "beat" goes linearly from one to the next and back to the first at R-R. Vertices and triangles
/// are in the order of the payload, positions in workspace [mm]; the root node makes metres of
/// them, along +x the patient's left, +y the head, +z the front, as glTF 2.0 (3.4) wants.
/// Structures that enclose others can be seen through. The same surfaces give the same bytes.
/// @throws Error{InvalidInput} if there is no surface, the phases differ in number, or the file
/// would be larger than 4 GiB, which the form cannot hold.
[[nodiscard]] atlas::Bytes gltf_binary(
    const std::vector<std::shared_ptr<const atlas::SurfacePayload>>& surfaces,
    const GltfPlacement& placement);

}  // namespace beatlas::formats
