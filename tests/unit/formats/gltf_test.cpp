/// Our glTF as assimp, which shares no code with us, reads it.

#include "pipeline/formats/gltf.h"

#include <cstring>
#include <set>
#include <string>

#include <assimp/Importer.hpp>
#include <assimp/material.h>
#include <assimp/scene.h>
#include <gtest/gtest.h>

#include "runtime/atlas/structure_colours.h"
#include "runtime/base/error.h"
#include "tests/colour_vision.h"
#include "tests/package/sample_package.h"

namespace beatlas::formats {
namespace {

constexpr double kRr = 0.84;
// Positions near 130 mm are floats 1.5e-5 mm apart; a target's difference rounds twice more. A
// package's own quantisation is 0.01 mm.
constexpr double kTolMm = 1e-4;

using Surface = std::shared_ptr<const atlas::SurfacePayload>;

std::vector<Surface> two_surfaces(int phases) {
  return {std::make_shared<atlas::SurfacePayload>(
              test::beating_surface(Structure::Heart, 35, 6, phases, 3)),
          std::make_shared<atlas::SurfacePayload>(
              test::beating_surface(Structure::LvBlood, 18, 5, phases, 2))};
}

Affine oblique() {
  return Eigen::Translation3d(150, 90, 30) * Eigen::AngleAxisd(1.1, Vec3(1, -2, 0.5).normalized());
}

const aiScene& import(Assimp::Importer& importer, const atlas::Bytes& bytes) {
  const aiScene* scene = importer.ReadFileFromMemory(bytes.data(), bytes.size(), 0, "glb");
  if (scene == nullptr) throw std::runtime_error(importer.GetErrorString());
  return *scene;
}

Vec3 to_eigen(const aiVector3D& v) { return {double(v.x), double(v.y), double(v.z)}; }

double largest_difference(const aiVector3D* found, const std::vector<Vec3f>& expected) {
  double largest = 0;
  for (std::size_t v = 0; v < expected.size(); ++v) {
    largest = std::max(largest, (to_eigen(found[v]) - expected[v].cast<double>()).norm());
  }
  return largest;
}

TEST(Gltf, GivesEveryVertexOfEveryPhaseToAnotherReader) {
  const std::vector<Surface> surfaces = two_surfaces(7);
  Assimp::Importer importer;
  const aiScene& scene = import(importer, gltf_binary(surfaces, {oblique(), kRr}));
  ASSERT_EQ(scene.mNumMeshes, 2U);
  for (unsigned m = 0; m < 2; ++m) {
    const atlas::SurfacePayload& surface = *surfaces[m];
    const aiMesh& mesh = *scene.mMeshes[m];
    ASSERT_EQ(mesh.mNumVertices, surface.positions[0].size());
    ASSERT_EQ(mesh.mNumFaces, surface.triangles.size());
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      ASSERT_EQ(mesh.mFaces[f].mNumIndices, 3U);
      ASSERT_EQ(0, std::memcmp(mesh.mFaces[f].mIndices, surface.triangles[f].data(), 12)) << f;
    }
    EXPECT_LE(largest_difference(mesh.mVertices, surface.positions[0]), kTolMm);
    ASSERT_EQ(mesh.mNumAnimMeshes, 6U);
    for (unsigned p = 1; p < 7; ++p) {
      const aiAnimMesh& target = *mesh.mAnimMeshes[p - 1];
      ASSERT_EQ(target.mNumVertices, mesh.mNumVertices);
      EXPECT_LE(largest_difference(target.mVertices, surface.positions[p]), kTolMm) << p;
    }
    // The ball's largest motion is 6 mm, so a target that is not applied cannot pass.
    EXPECT_GT(largest_difference(mesh.mVertices, surface.positions[3]), 3);
  }
}

TEST(Gltf, PlacesTheHeartInMetresWithTheHeadUpAndTheFrontForward) {
  const std::vector<Surface> surfaces = two_surfaces(3);
  Assimp::Importer importer;
  const aiScene& scene = import(importer, gltf_binary(surfaces, {oblique(), kRr}));
  for (const Surface& surface : surfaces) {
    const aiNode* node = scene.mRootNode->FindNode(structure_name(surface->structure).data());
    ASSERT_NE(node, nullptr);
    ASSERT_EQ(node->mNumMeshes, 1U);
    aiMatrix4x4 to_world;
    for (const aiNode* at = node; at != nullptr; at = at->mParent) {
      to_world = at->mTransformation * to_world;
    }
    const Vec3f& vertex = surface->positions[0][5];
    const Vec3 found = to_eigen(to_world * scene.mMeshes[node->mMeshes[0]]->mVertices[5]);
    const Vec3 lps = oblique().inverse() * vertex.cast<double>();
    // +x left, +y superior, +z anterior; a micrometre, floats near 0.2 m are 1.5e-8 m apart.
    EXPECT_LT((found - 1e-3 * Vec3(lps.x(), lps.z(), -lps.y())).norm(), 1e-6);
  }
}

TEST(Gltf, BeatsLinearlyFromPhaseToPhaseAndBackToTheFirst) {
  Assimp::Importer importer;
  const aiScene& scene = import(importer, gltf_binary(two_surfaces(5), {oblique(), kRr}));
  ASSERT_EQ(scene.mNumAnimations, 1U);
  const aiAnimation& beat = *scene.mAnimations[0];
  EXPECT_STREQ(beat.mName.C_Str(), "beat");
  ASSERT_EQ(beat.mNumMorphMeshChannels, 2U);
  std::set<std::string> moved;
  for (unsigned c = 0; c < 2; ++c) {
    const aiMeshMorphAnim& channel = *beat.mMorphMeshChannels[c];
    moved.insert(channel.mName.C_Str());
    ASSERT_EQ(channel.mNumKeys, 6U);
    for (unsigned k = 0; k < 6; ++k) {
      const aiMeshMorphKey& key = channel.mKeys[k];
      EXPECT_NEAR(key.mTime / beat.mTicksPerSecond, kRr * k / 5, 1e-6);
      ASSERT_EQ(key.mNumValuesAndWeights, 4U);
      for (unsigned w = 0; w < 4; ++w) {
        EXPECT_EQ(key.mWeights[key.mValues[w]], w + 1 == k ? 1.0 : 0.0) << k << " " << w;
      }
    }
  }
  EXPECT_EQ(moved, (std::set<std::string>{"heart", "lv_blood"}));
}

TEST(Gltf, ShadesSmoothlyFromOutsideAndLetsOuterStructuresBeSeenThrough) {
  const std::vector<Surface> surfaces = two_surfaces(2);
  Assimp::Importer importer;
  const aiScene& scene = import(importer, gltf_binary(surfaces, {oblique(), kRr}));
  for (unsigned m = 0; m < 2; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const Vec3 normal = to_eigen(mesh.mNormals[v]);
      EXPECT_NEAR(normal.norm(), 1, 1e-5);
      // A ball with bumps of 5 %, 5 to the turn: within 45 degrees of the radius.
      const Vec3 radius = to_eigen(mesh.mVertices[v]) - Vec3(128, 128, 96);
      EXPECT_GT(normal.dot(radius.normalized()), 0.7);
    }
    const aiMaterial& material = *scene.mMaterials[mesh.mMaterialIndex];
    EXPECT_EQ(std::string(material.GetName().C_Str()), structure_name(surfaces[m]->structure));
    aiColor4D colour;
    ASSERT_EQ(material.Get(AI_MATKEY_BASE_COLOR, colour), AI_SUCCESS);
    EXPECT_EQ(colour.a < 1, surfaces[m]->structure == Structure::Heart);
    // The same colour as everywhere else, as linear light.
    const Vec3 wanted = test::linear_of(structure_colour(surfaces[m]->structure));
    EXPECT_LT((Vec3(colour.r, colour.g, colour.b) - wanted).norm(), 1e-6);
  }
}

TEST(Gltf, OfOnePhaseStandsStill) {
  Assimp::Importer importer;
  const aiScene& scene = import(importer, gltf_binary(two_surfaces(1), {oblique(), kRr}));
  EXPECT_EQ(scene.mNumAnimations, 0U);
  ASSERT_EQ(scene.mNumMeshes, 2U);
  EXPECT_EQ(scene.mMeshes[0]->mNumAnimMeshes, 0U);
}

TEST(Gltf, IsTheSameTwiceAndRefusesWhatHasNoSurfaceOrNoCommonPhases) {
  EXPECT_EQ(gltf_binary(two_surfaces(3), {oblique(), kRr}),
            gltf_binary(two_surfaces(3), {oblique(), kRr}));
  EXPECT_THROW((void)gltf_binary({}, {oblique(), kRr}), Error);
  std::vector<Surface> mixed = two_surfaces(3);
  mixed[1] = two_surfaces(4)[1];
  EXPECT_THROW((void)gltf_binary(mixed, {oblique(), kRr}), Error);
}

}  // namespace
}  // namespace beatlas::formats
