// Meshes from OBJ and PLY files in all their variants, and what is said about files that are wrong.
#include "scene/mesh_file.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cstdio>
#include <filesystem>
#include <functional>

#include "scene/obj_mesh.hpp"
#include "scene/ply_mesh.hpp"

namespace salvo::scene {
namespace {

using models::TriangleMesh;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;

std::string mistake_in(const std::function<TriangleMesh()>& read) {
  try {
    read();
  } catch (const MeshError& error) {
    return std::string(error.what()) + " | " + error.hint();
  }
  return "no mistake";
}

// ---- OBJ ----------------------------------------------------------------------------------------

TriangleMesh obj(const std::string& text) { return read_obj(text, "a.obj"); }
std::string obj_mistake(const std::string& text) {
  return mistake_in([&] { return obj(text); });
}

const std::string square_vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TEST(ObjFile, TrianglesAreRead) {
  const TriangleMesh mesh = obj("v 0 0 0\nv 1.5 -2e-1 +.25\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(mesh.vertices, (std::vector<models::Triple>{{0, 0, 0}, {1.5, -0.2, 0.25}, {0, 1, 0}}));
  EXPECT_EQ(mesh.triangles, (Triangles{{0, 1, 2}}));
}

TEST(ObjFile, CornersMayNameTextureAndNormalAndCountBackwards) {
  const Triangles two{{0, 1, 2}, {0, 2, 3}};
  for (const char* const faces :
       {"f 1 2 3\nf 1 3 4", "f 1/1 2/2 3/3\nf 1/9 3/8 4/7\n",
        "f 1//5 2//5 3//5\nf 1//6 3//-6 4//6\n", "f 1/2/3 2/2/3 3/2/3\nf 1/2/3 3/2/3 4/2/3\n",
        "f -4 -3 -2\nf -4/1 -2/-1/1 -1//1\n"}) {
    EXPECT_EQ(obj(square_vertices + faces).triangles, two) << faces;
  }
  // Backwards from where the face stands; forwards to vertices that come later.
  EXPECT_EQ(obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nf 1 3 4\nv 0 1 0\n").triangles, two);
}

TEST(ObjFile, PolygonsBecomeFans) {
  EXPECT_EQ(obj(square_vertices + "f 2 3 4 1\n").triangles, (Triangles{{1, 2, 3}, {1, 3, 0}}));
  EXPECT_EQ(obj("v 0 0 0\nv 2 0 0\nv 3 1 0\nv 2 2 0\nv 0 2 0\nf 1 2 3 4 5\n").triangles,
            (Triangles{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
}

TEST(ObjFile, WhatIsNoSurfaceIsPassedOver) {
  const std::string text =
      "\xEF\xBB\xBF# made by hand\r\nmtllib a.mtl\r\no square\r\n\r\n"
      "v 0 0 0 1.0\r\n\tv  1 0 0  # a corner\r\nv 1 1 0 0.5 0.5 0.5\r\nv 0 1 0 1 0.5 0.5 0.5\r\n"
      "vt 0 0\r\nvn 0 0 1\r\ng side\r\nusemtl red\r\ns off\r\nl 1 2\r\np 1\r\n"
      "f 1 2 \\\r\n3 \\\r\n4 \r\n";
  const TriangleMesh mesh = obj(text);
  EXPECT_EQ(mesh.vertices.size(), 4u);
  EXPECT_EQ(mesh.triangles, (Triangles{{0, 1, 2}, {0, 2, 3}}));
}

TEST(ObjFile, MistakesNameTheirLine) {
  const std::string& square = square_vertices;
  EXPECT_EQ(obj_mistake(""), "a.obj: the mesh has no triangles | expected at least one");
  EXPECT_EQ(obj_mistake("v 0 0 0\nv 1 0 x\n"),
            "a.obj:2: \"x\" is no number | expected v X Y Z, decimal numbers");
  EXPECT_EQ(obj_mistake("v 0 0 1,5\n"),
            "a.obj:1: \"1,5\" is no number | expected v X Y Z, decimal numbers");
  EXPECT_EQ(obj_mistake("v 0 0 1e999\n"),
            "a.obj:1: \"1e999\" is out of range | expected v X Y Z, decimal numbers");
  EXPECT_EQ(obj_mistake("v 0 nan 0\n"),
            "a.obj:1: a vertex at (0, nan, 0) | expected finite coordinates of at most 1e+30");
  EXPECT_EQ(obj_mistake("v 0 0\n"),
            "a.obj:1: a vertex of 2 numbers | expected v X Y Z, and a weight or a colour if need "
            "be");
  EXPECT_EQ(obj_mistake("v 1 2 3 4 5\n"),
            "a.obj:1: a vertex of 5 numbers | expected v X Y Z, and a weight or a colour if need "
            "be");
  EXPECT_EQ(obj_mistake(square + "f 1 2\n"), "a.obj:5: a face of 2 vertices | expected at least 3");
  EXPECT_EQ(obj_mistake(square + "\nf 1 2 5\n"),
            "a.obj:6: a face refers to vertex 5 | the file has 4 vertices, numbered from 1");
  EXPECT_EQ(obj_mistake(square + "f 1 0 2\n"),
            "a.obj:5: a face refers to vertex 0 | expected numbers from 1 on, or from -1 back to "
            "-4");
  EXPECT_EQ(obj_mistake(square + "f 1 2 -5\n"),
            "a.obj:5: a face refers to vertex -5 | expected numbers from 1 on, or from -1 back to "
            "-4");
  for (const std::string corner :
       {"x", "1.5", "3/", "3//", "3/1/", "/1/1", "3/a", "3/1/2/3", "1-2"}) {
    EXPECT_EQ(obj_mistake(square + "f 1 2 " + corner + "\n"),
              "a.obj:5: \"" + corner +
                  "\" is no corner of a face | expected VERTEX, VERTEX/TEXTURE, VERTEX//NORMAL or "
                  "VERTEX/TEXTURE/NORMAL, whole numbers");
  }
  EXPECT_EQ(obj_mistake("v 0 0 0\nface 1 2 3\n"),
            "a.obj:2: \"face\" is no keyword of flat polygons | expected v or f; passed over are "
            "vt, vn, vp, g, o, s, mg, usemtl, mtllib, lod, bevel, c_interp, d_interp, shadow_obj, "
            "trace_obj, usemap, maplib, l, p");
  EXPECT_EQ(
      obj_mistake(std::string("\0\x01\xff", 3) + "v 1\n"),
      "a.obj:1: \"\\x00\\x01\\xffv\" is no keyword of flat polygons | expected v or f; "
      "passed over are vt, vn, vp, g, o, s, mg, usemtl, mtllib, lod, bevel, c_interp, d_interp, "
      "shadow_obj, trace_obj, usemap, maplib, l, p");
  // The line on which what is continued began.
  EXPECT_EQ(obj_mistake(square + "f 1 \\\n2 \\\n9\n"),
            "a.obj:5: a face refers to vertex 9 | the file has 4 vertices, numbered from 1");
}

TEST(ObjFile, PolygonsMustBeConvex) {
  const std::string arrow = "v 0 0 0\nv 2 0 0\nv 0.5 0.5 0\nv 0 2 0\n";
  EXPECT_EQ(obj_mistake(arrow + "f 2 3 4 1\n"),
            "a.obj:5: a face is folded or not convex | cut it into triangles");
  // Both halves of a square whose corners cross are of the same size and look opposite ways.
  EXPECT_EQ(obj_mistake(square_vertices + "f 1 2 4 3\n"),
            "a.obj:5: a face is folded or not convex | cut it into triangles");
  // Not convex either, but this fan covers it.
  EXPECT_EQ(obj_mistake(arrow + "f 1 2 3 4\n"), "no mistake");
}

TEST(ObjFile, MistakesOfTheSurfaceNameTheLineOfTheirTriangle) {
  EXPECT_EQ(obj_mistake(square_vertices + "f 1 2 3\nf 1 4 3\n"),
            "a.obj:6: triangles 1 and 2 run along their edge from (0, 0, 0) to (1, 1, 0) in the "
            "same direction | reverse the order of the vertices of one of them");
  EXPECT_EQ(obj_mistake(square_vertices + "f 1 2 3 4\nf 3 2 1\nf 1 1 2\n"),
            "a.obj:6: triangle 3 has the corners of triangle 1 (and 1 more) | remove one of them: "
            "a surface has two sides");
}

// ---- PLY ----------------------------------------------------------------------------------------

TriangleMesh ply(const std::string& bytes) { return read_ply(bytes, "a.ply"); }
std::string ply_mistake(const std::string& bytes) {
  return mistake_in([&] { return ply(bytes); });
}

// A square with properties and elements that are no part of it.
std::string header(const std::string& format, const std::string& real = "float",
                   const std::string& count = "uchar", const std::string& whole = "int",
                   const std::string& corners = "vertex_indices") {
  return "ply\nformat " + format + " 1.0\ncomment made by hand\nobj_info none\n" +
         "element camera 1\nproperty double field\nproperty list ushort short sizes\n" +
         "element vertex 4\nproperty uchar red\nproperty " + real + " x\nproperty " + real +
         " y\nproperty list uchar float marks\nproperty " + real + " z\n" +
         "element face 2\nproperty list " + count + " " + whole + " " + corners +
         "\nproperty char flags\nend_header\n";
}

const std::vector<models::Triple> square{{0, 0, 0}, {2, 0, -1}, {2, 2, -1}, {0, 2, 0}};

const std::string text_body =
    "50.5 2 -1 300\n"
    "255 0 0 0 0\n"
    "255 2 0 1 0.5 -1\n"
    "\n"
    "255 2 2 2 0.5 nan -1\n"
    "255 0 2 0 0\n"
    "3 0 1 2 -7\n"
    "3 0 2 3 -128\n";

class Bytes {
 public:
  explicit Bytes(bool big) : big_(big) {}

  void natural(std::uint64_t value, std::size_t bytes) {
    for (std::size_t i = 0; i < bytes; ++i) {
      const std::size_t byte = big_ ? bytes - 1 - i : i;
      text_ += static_cast<char>(value >> (8 * byte) & 0xFF);
    }
  }
  void number(const std::string& type, double value) {
    const auto whole = static_cast<std::int64_t>(value);
    if (type == "float" || type == "float32") {
      natural(std::bit_cast<std::uint32_t>(static_cast<float>(value)), 4);
    } else if (type == "double" || type == "float64") {
      natural(std::bit_cast<std::uint64_t>(value), 8);
    } else if (type == "char" || type == "int8" || type == "uchar" || type == "uint8") {
      natural(static_cast<std::uint64_t>(whole), 1);
    } else if (type == "short" || type == "int16" || type == "ushort" || type == "uint16") {
      natural(static_cast<std::uint64_t>(whole), 2);
    } else {
      natural(static_cast<std::uint64_t>(whole), 4);
    }
  }
  const std::string& text() const { return text_; }

 private:
  bool big_;
  std::string text_;
};

std::string binary_body(bool big, const std::string& real = "float",
                        const std::string& count = "uchar", const std::string& whole = "int") {
  Bytes bytes(big);
  bytes.number("double", 50.5);
  bytes.number("ushort", 2);
  bytes.number("short", -1);
  bytes.number("short", 300);
  for (std::size_t v = 0; v < 4; ++v) {
    bytes.number("uchar", 255);
    bytes.number(real, square[v][0]);
    bytes.number(real, square[v][1]);
    bytes.natural(v % 2, 1);
    for (std::size_t i = 0; i < v % 2; ++i) bytes.number("float", 0.5);
    bytes.number(real, square[v][2]);
  }
  for (const int second : {1, 2}) {
    bytes.number(count, 3);
    bytes.number(whole, 0);
    bytes.number(whole, second);
    bytes.number(whole, second + 1);
    bytes.number("char", -7);
  }
  return bytes.text();
}

TEST(PlyFile, TextIsRead) {
  for (const char* const corners : {"vertex_indices", "vertex_index"}) {
    const TriangleMesh mesh = ply(header("ascii", "float", "uchar", "int", corners) + text_body);
    EXPECT_EQ(mesh.vertices, square);
    EXPECT_EQ(mesh.triangles, (Triangles{{0, 1, 2}, {0, 2, 3}}));
  }
}

TEST(PlyFile, LinesMayEndInCarriageReturns) {
  const auto with_returns = [](const std::string& text) {
    std::string result;
    for (const char c : text) result += c == '\n' ? std::string("\r\n") : std::string(1, c);
    return result;
  };
  EXPECT_EQ(ply(with_returns(header("ascii") + text_body)).vertices, square);
  EXPECT_EQ(ply(with_returns(header("binary_big_endian")) + binary_body(true)).vertices, square);
}

TEST(PlyFile, BinaryIsReadInBothByteOrdersAndAllTypes) {
  const char* const reals[] = {"float", "float32", "double", "float64", "int", "short", "int8"};
  const char* const wholes[] = {"char", "uchar", "short", "ushort", "int",   "uint",
                                "int8", "uint8", "int16", "uint16", "int32", "uint32"};
  for (const bool big : {false, true}) {
    const std::string format = big ? "binary_big_endian" : "binary_little_endian";
    for (const char* const real : reals) {
      for (const char* const whole : wholes) {
        const TriangleMesh mesh =
            ply(header(format, real, whole, whole) + binary_body(big, real, whole, whole));
        EXPECT_EQ(mesh.vertices, square) << format << " " << real;
        EXPECT_EQ(mesh.triangles, (Triangles{{0, 1, 2}, {0, 2, 3}})) << format << " " << whole;
      }
    }
  }
}

TEST(PlyFile, FacesMayComeFirstAndBePolygons) {
  EXPECT_EQ(ply("ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_index\n"
                "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                "end_header\n4 0 1 2 3\n0 0 0\n1 0 0\n1 1 0\n0 1 0")
                .triangles,
            (Triangles{{0, 1, 2}, {0, 2, 3}}));
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(PlyFile, MistakesOfTheHeaderNameTheirLine) {
  const std::string good = header("ascii") + text_body;
  const auto mistake = [&](const std::string& from, const std::string& to) {
    return ply_mistake(replaced(good, from, to));
  };
  const std::string formats =
      "expected format ascii 1.0, format binary_little_endian 1.0 or format binary_big_endian 1.0";
  EXPECT_EQ(ply_mistake("solid cube\n"),
            "a.ply:1: the first line is not \"ply\" | expected a PLY file");
  EXPECT_EQ(ply_mistake(""), "a.ply:1: the first line is not \"ply\" | expected a PLY file");
  EXPECT_EQ(ply_mistake("ply\nformat ascii 1.0\nelement vertex 4\n"),
            "a.ply: the header has no end | expected a line end_header");
  EXPECT_EQ(mistake("format ascii 1.0\n", ""), "a.ply: the header has no format | " + formats);
  EXPECT_EQ(mistake("ascii 1.0", "ascii 2.0"), "a.ply:2: the format is \"ascii 2.0\" | " + formats);
  EXPECT_EQ(mistake("ascii 1.0", "binary 1.0"),
            "a.ply:2: the format is \"binary 1.0\" | " + formats);
  EXPECT_EQ(mistake("obj_info", "info"),
            "a.ply:4: \"info\" is no keyword of a header | expected format, comment, obj_info, "
            "element, property or end_header");
  EXPECT_EQ(mistake("element vertex 4", "element vertex four"),
            "a.ply:8: \"four\" is no number of rows | expected element NAME ROWS");
  EXPECT_EQ(mistake("element vertex 4", "element vertex -4"),
            "a.ply:8: \"-4\" is no number of rows | expected element NAME ROWS");
  EXPECT_EQ(mistake("element vertex 4", "element vertex 4 5"),
            "a.ply:8: the line goes on | expected one declaration a line");
  EXPECT_EQ(mistake("element camera", "element vertex"),
            "a.ply:8: a second element vertex | expected names that differ");
  EXPECT_EQ(mistake("element camera 1\n", ""),
            "a.ply:5: a property of no element | expected element before it");
  EXPECT_EQ(mistake("uchar red", "byte red"),
            "a.ply:9: \"byte\" is no type | expected char, uchar, short, ushort, int, uint, float "
            "or double");
  EXPECT_EQ(mistake("uchar red", "uchar"),
            "a.ply:9: a property without a name | expected property TYPE NAME or property list "
            "TYPE TYPE NAME");
  EXPECT_EQ(mistake("uchar red", "uchar x"),
            "a.ply:10: a second property x | expected names that differ");
  EXPECT_EQ(mistake("list uchar float", "list float float"),
            "a.ply:12: the length of a list is no whole number | expected an integer type, as "
            "uchar");
  EXPECT_EQ(mistake("element vertex", "element vertices"),
            "a.ply: it has no element vertex | expected vertices and faces");
  EXPECT_EQ(mistake("element face", "element tristrips"),
            "a.ply: it has no element face | expected vertices and faces");
  EXPECT_EQ(mistake("float y", "float height"),
            "a.ply:8: element vertex has no property y | expected x, y and z");
  EXPECT_EQ(mistake("float x", "list uchar float x"),
            "a.ply: property x of its vertices is a list | expected property float x");
  EXPECT_EQ(mistake("vertex_indices", "corners"),
            "a.ply:14: element face has no property vertex_indices | expected property list uchar "
            "int vertex_indices");
  EXPECT_EQ(mistake("list uchar int vertex_indices", "list uchar float vertex_indices"),
            "a.ply: property vertex_indices of its faces is no list of whole numbers | expected "
            "property list uchar int vertex_indices");
}

TEST(PlyFile, MistakesOfTextRowsNameTheirLine) {
  const std::string good = header("ascii") + text_body;
  const auto mistake = [&](const std::string& from, const std::string& to) {
    return ply_mistake(replaced(good, from, to));
  };
  EXPECT_EQ(mistake("255 2 0 1 0.5 -1", "255 2 a 1 0.5 -1"),
            "a.ply:20: \"a\" is no number | property y is float");
  EXPECT_EQ(mistake("255 2 0 1 0.5 -1", "256 2 0 1 0.5 -1"),
            "a.ply:20: \"256\" is out of range | property red is uchar");
  EXPECT_EQ(mistake("255 2 0 1 0.5 -1", "2.5 2 0 1 0.5 -1"),
            "a.ply:20: \"2.5\" is no whole number | property red is uchar");
  EXPECT_EQ(mistake("255 2 0 1 0.5 -1", "255 2 0 1 0.5 inf"),
            "a.ply:20: a vertex at (2, 0, inf) | expected finite coordinates of at most 1e+30");
  EXPECT_EQ(mistake("255 2 0 1 0.5 -1", "255 2 0 1 0.5"),
            "a.ply:20: the row ends before property z | expected all properties of vertex");
  EXPECT_EQ(mistake("255 2 0 1 0.5 -1", "255 2 0 1 0.5 -1 3"),
            "a.ply:20: the row goes on after the properties of vertex | expected one row a line");
  EXPECT_EQ(mistake("3 0 2 3", "3 0 2 -3"),
            "a.ply:25: a face refers to vertex -3 | expected numbers from 0 on");
  EXPECT_EQ(mistake("3 0 2 3", "3 0 2 4"),
            "a.ply:25: a face refers to vertex 4 | the file has 4 vertices, numbered from 0");
  EXPECT_EQ(mistake("3 0 2 3", "2 0 2"), "a.ply:25: a face of 2 vertices | expected at least 3");
  EXPECT_EQ(mistake("3 0 2 3", "3 0 3 2"),
            "a.ply:25: triangles 1 and 2 run along their edge from (0, 0, 0) to (2, 2, -1) in the "
            "same direction | reverse the order of the vertices of one of them");
  EXPECT_EQ(mistake("3 0 2 3", "-3 0 2 3"),
            "a.ply:25: \"-3\" is out of range | property vertex_indices is a list of uchar");
  EXPECT_EQ(mistake("3 0 2 3 -128\n", ""),
            "a.ply:24: the file ends in row 2 of 2 of element face | it is cut off, or its header "
            "is wrong");
  EXPECT_EQ(mistake("element face 2", "element face 1"),
            "a.ply:25: the file goes on after its last element | the header announces too few "
            "rows");
  EXPECT_EQ(mistake("element face 2", "element face 99999999999999"),
            "a.ply:25: the file ends in row 3 of 99999999999999 of element face | it is cut off, "
            "or its header is wrong");
}

TEST(PlyFile, MistakesOfBinaryRowsNameTheirByte) {
  const std::string head = header("binary_little_endian", "float", "int", "int");
  const std::string body = binary_body(false, "float", "int", "int");
  const std::size_t faces = head.size() + 14 + 4 * 14 + 2 * 4;
  ASSERT_EQ(head.size() + body.size(), faces + 2 * 17);
  const auto changed = [&](std::size_t at, int value) {
    Bytes bytes(false);
    bytes.number("int", value);
    return ply_mistake((head + body).replace(at, 4, bytes.text()));
  };
  const std::string second = std::to_string(faces + 17);
  EXPECT_EQ(changed(faces + 17, 3), "no mistake");
  EXPECT_EQ(changed(faces + 17 + 4, 4),
            "a.ply: byte " + second +
                ": a face refers to vertex 4 | the file has 4 vertices, numbered from 0");
  EXPECT_EQ(changed(faces + 17 + 4, -1),
            "a.ply: byte " + second + ": a face refers to vertex -1 | expected numbers from 0 on");
  EXPECT_EQ(changed(faces + 17, -3),
            "a.ply: byte " + second +
                ": property vertex_indices has -3 values | the file is damaged, or its header is "
                "wrong");
  const std::string end = std::to_string(head.size() + body.size());
  EXPECT_EQ(changed(faces + 17, 2000000000),
            "a.ply: byte " + end +
                ": the file ends in row 2 of 2 of element face | it is cut off, or its header is "
                "wrong");
  EXPECT_EQ(changed(head.size() + 14 + 1, 0x7F800000),
            "a.ply: byte " + std::to_string(head.size() + 14) +
                ": a vertex at (inf, 0, 0) | expected finite coordinates of at most 1e+30");
  EXPECT_EQ(ply_mistake(head + body + "\n"),
            "a.ply: byte " + end +
                ": the file goes on after its last element | the header announces too few rows");
  // Cut off anywhere.
  for (std::size_t length = head.size(); length < head.size() + body.size(); ++length) {
    EXPECT_TRUE(
        ply_mistake((head + body).substr(0, length))
            .starts_with("a.ply: byte " + std::to_string(length) + ": the file ends in row"))
        << length;
  }
}

// ---- files --------------------------------------------------------------------------------------

TEST(MeshFile, IsReadByItsEnding) {
  const std::filesystem::path folder = testing::TempDir();
  const auto write = [&](const char* name, const std::string& bytes) {
    std::FILE* file = std::fopen((folder / name).c_str(), "wb");
    std::fwrite(bytes.data(), 1, bytes.size(), file);
    std::fclose(file);
    return (folder / name).string();
  };
  const std::string one = write("salvo_mesh_test.OBJ", square_vertices + "f 1 2 3 4\n");
  const std::string other =
      write("salvo_mesh_test.ply", header("binary_big_endian") + binary_body(true));
  EXPECT_EQ(read_mesh(one).mesh.triangles, read_mesh(other).mesh.triangles);
  std::filesystem::remove(one);
  std::filesystem::remove(other);
}

TEST(MeshFile, ThatCannotBeReadIsNamed) {
  EXPECT_EQ(mistake_in([] { return read_mesh("no/such/mesh.obj").mesh; }),
            "cannot read no/such/mesh.obj: No such file or directory | its path is relative to the "
            "scene's");
  EXPECT_EQ(mistake_in([] { return read_mesh("mesh.stl").mesh; }),
            "mesh.stl is no mesh by its name | expected a file that ends in .obj or .ply");
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / "salvo_mesh_test_folder.obj";
  std::filesystem::create_directory(folder);
  EXPECT_EQ(
      mistake_in([&] { return read_mesh(folder.string()).mesh; }),
      "cannot read " + folder.string() + ": Is a directory | its path is relative to the scene's");
  std::filesystem::remove(folder);
}

// The shipped mesh: closed, facing outwards, of the volume of its 32-sided frustums.
TEST(MeshFile, HourglassIsAClosedSolid) {
  const TriangleMesh mesh = read_mesh(SALVO_SCENES "/contact/hourglass.obj").mesh;
  const models::MeshFeatures features = models::make_features(mesh);
  for (const models::MeshEdge& edge : features.edges) EXPECT_EQ(edge.side_count, 2u);
  // Caps, and the sides of five rings: the quadrilaterals are flat.
  EXPECT_EQ(features.patches.size(), 2u + 5 * 32);
  double volume = 0;
  models::Triple lowest{9, 9, 9};
  models::Triple highest{-9, -9, -9};
  for (const auto& [i, j, k] : mesh.triangles) {
    using Vec = kernels::Vec3<double>;
    const auto at = [&](std::uint32_t v) -> Vec {
      const models::Triple& p = mesh.vertices[v];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        lowest[axis] = std::min(lowest[axis], p[axis]);
        highest[axis] = std::max(highest[axis], p[axis]);
      }
      return {p[0], p[1], p[2]};
    };
    volume += dot(at(i), cross(at(j), at(k))) / 6;
  }
  const double polygon = 16 * 0.19509032201612825;  // area of the 32-gon on the unit circle
  const auto frustum = [&](double r, double s, double height) {
    return polygon * height * (r * r + r * s + s * s) / 3;
  };
  EXPECT_NEAR(
      volume,
      2 * frustum(0.25, 0.25, 0.15) + 2 * frustum(0.25, 0.05, 0.32) + frustum(0.05, 0.05, 0.06),
      1e-9);
  EXPECT_EQ(lowest, (models::Triple{-0.25, 0, -0.25}));
  EXPECT_EQ(highest, (models::Triple{0.25, 1, 0.25}));
}

}  // namespace
}  // namespace salvo::scene
