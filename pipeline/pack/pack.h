#pragma once
#include <filesystem>
#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"
#include "runtime/atlas/manifest.h"
#include "runtime/atlas/payloads.h"

namespace beatlas::pack {

struct EncodeOptions {
  double step_mm = 0.01;  ///< [mm] 0.0005..0.1: quantisation of distance coefficients
};

/// Samples -> prefiltered space-time spline coefficients, quantised and made sparse.
[[nodiscard]] atlas::FieldPayload encode_field(const FieldCycle& field,
                                               const EncodeOptions& options);

/// What goes into a package; `manifest.items` is filled by the writer.
struct PackageContent {
  atlas::Manifest manifest;
  std::vector<atlas::FieldPayload> fields;
  std::vector<atlas::SurfacePayload> surfaces;
};

/// Writes to a temporary name beside `file` and renames. The same content gives the same bytes.
/// @throws Error{Machine} if it cannot be written; nothing is left then.
void write_package(const std::filesystem::path& file, const PackageContent& content);

}  // namespace beatlas::pack
