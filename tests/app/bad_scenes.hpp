#pragma once
// Scene files that must be refused, each with the place, the key and a part of the message.

namespace drench::testing {

struct BadScene {
  const char* name;
  const char* yaml;
  int line, column;
  const char* key;       // what stands behind file:line:column
  const char* fragment;  // of what follows it
};

#define HEAD "drench: 1\n"
// Lines 1 to 3; keys of the fluid follow from line 4, indented by 2.
#define FLUID HEAD "fluid:\n  sources: [{block: {min: [0, 0, 0], max: [1, 1, 1]}}]\n"
// Lines 1 to 3; keys of the cloth follow from line 4, indented by 4.
#define CLOTH HEAD "cloth:\n  - mesh: {grid: {nodes: [5, 5]}}\n"
// Lines 1 to 3; one source follows on line 4, indented by 4.
#define SOURCES HEAD "fluid:\n  sources:\n"
// Lines 1 to 4; bodies follow from line 5.
#define BODIES FLUID "bodies:\n"

inline constexpr BadScene bad_scenes[] = {
    // the file as a whole
    {"Empty", "", 1, 1, "scene", "is empty"},
    {"OnlyAComment", "# nothing\n", 1, 1, "scene", "is empty"},
    {"RootIsAList", "- 1\n- 2\n", 1, 1, "scene", "a list of 2; allowed: a map"},
    {"RootIsAWord", "water\n", 1, 1, "scene", "'water'; allowed: a map"},
    {"NoVersion", "fluid: {sources: [{block: {min: [0, 0, 0], max: [1, 1, 1]}}]}\n", 1, 1, "drench", "is missing"},
    {"VersionOfTheFuture", "drench: 2\n", 1, 9, "drench", "'2' is out of range; allowed: [1, 1]"},
    {"NothingInIt", HEAD, 1, 1, "fluid", "neither fluid nor cloth"},
    {"TwoDocuments", FLUID "---\n" FLUID, 4, 1, "syntax", "a second document"},
    {"UnknownSection", FLUID "fluids: {}\n", 4, 1, "fluids", "did you mean 'fluid'?"},
    {"UnknownSectionFarFromAll", FLUID "colour: red\n", 4, 1, "colour", "allowed: drench, time, gravity"},
    {"SectionIsNothing", FLUID "time:\n", 4, 1, "time", "is nothing; allowed: a map"},
    {"SectionIsANumber", FLUID "time: 3\n", 4, 7, "time", "is '3'; allowed: a map"},
    // YAML itself
    {"OpenBracket", "drench: 1\ngravity: [0, 1\n", 3, 1, "syntax", "end of sequence"},
    {"BadIndentation", "drench: 1\nfluid:\n  spacing: 1\n density: 2\n", 4, 2, "syntax", "end of map"},
    {"OpenQuote", "drench: 1\ncloth: \"abc\n", 2, 8, "syntax", "a quote that is never closed"},
    {"OpenQuoteWithEscape", "drench: 1\ncloth: \"abc\\\"", 2, 14, "syntax", "EOF in scalar"},
    {"OpenSingleQuote", "drench: 1\ncloth: &a 'it''s\n\n", 2, 8, "syntax", "a quote that is never closed"},
    {"TabIndents", "drench: 1\nfluid:\n\tspacing: 1\n", 3, 1, "syntax", "a tab in the indentation"},
    {"TabBehindSpaces", "drench: 1\nfluid:\n  \tspacing: 1\n", 3, 3, "syntax", "allowed: spaces"},
    {"EndOfTransmission", "drench: 1\nx\x04: 1\n", 2, 2, "syntax", "the byte 0x04"},
    {"NotUtf8",
     "\xff\xfe"
     "drench: 1\n",
     1, 1, "syntax", "the byte 0xff; allowed: text in UTF-8"},
    {"Tag", "drench: !!int 1\n", 1, 9, "syntax", "allowed: no tags"},
    {"UnknownAlias", "drench: *one\n", 1, 9, "syntax", "anchor is not defined"},
    {"AliasOfItself", "drench: 1\nfluid: &f {sources: *f}\n", 2, 21, "syntax", "inside of its own anchor"},
    {"KeyIsAList", "drench: 1\n[1, 2]: 3\n", 2, 1, "syntax", "a key that is not a word"},
    {"DuplicateSection", "drench: 1\ntime: {}\ntime: {}\n", 3, 1, "time", "is given twice, first at line 2, column 1"},
    {"DuplicateKey", FLUID "  spacing: 1\n  spacing: 2\n", 5, 3, "fluid.spacing", "is given twice, first at line 4"},
    {"DuplicateKeyInAList", CLOTH "    bend: 1\n    bend: 1\n", 5, 5, "cloth.0.bend", "is given twice"},
    // time, gravity, domain, output, neighbors
    {"StepIsZero", FLUID "time: {step: 0}\n", 4, 14, "time.step", "'0' is out of range; allowed: (0, 1] s"},
    {"StepIsLong", FLUID "time: {step: 1.5}\n", 4, 14, "time.step", "allowed: (0, 1] s"},
    {"StepIsAWord", FLUID "time: {step: soon}\n", 4, 14, "time.step", "'soon' is not a number; allowed: (0, 1] s"},
    {"StepIsQuoted", FLUID "time: {step: \"0.1\"}\n", 4, 14, "time.step", "is not a number"},
    {"StepHasAUnit", FLUID "time: {step: 4 ms}\n", 4, 14, "time.step", "'4 ms' is not a number"},
    {"StepIsNaN", FLUID "time: {step: .nan}\n", 4, 14, "time.step", "is not a finite double"},
    {"StepIsNothing", FLUID "time: {step: }\n", 4, 8, "time.step", "nothing is not a number"},
    {"EndIsInfinite", FLUID "time: {end: .inf}\n", 4, 13, "time.end", "is not a finite double; allowed: (0, 1e6] s"},
    {"EndOverflows", FLUID "time: {end: 1e999}\n", 4, 13, "time.end", "is not a finite double"},
    {"EndIsNegative", FLUID "time: {end: -1}\n", 4, 13, "time.end", "'-1' is out of range"},
    {"CflIsLarge", FLUID "time: {cfl: 2}\n", 4, 13, "time.cfl", "allowed: (0, 1] (no unit)"},
    {"ModeMisspelt", FLUID "time: {mode: fixd}\n", 4, 14, "time.mode", "did you mean 'fixed'? allowed: fixed, cfl"},
    {"ModeUnknown", FLUID "time: {mode: implicit}\n", 4, 14, "time.mode",
     "'implicit' is not known; allowed: fixed, cfl"},
    {"FieldWithoutRate", FLUID "field: {center: [0, 0, 0]}\n", 4, 8, "field.rate", "is missing"},
    {"FieldOfNothing", FLUID "field: {rate: [0, 0, 0]}\n", 4, 15, "field.rate", "has length 0"},
    {"FieldThatPushes", FLUID "field: {rate: [1, -1, 0]}\n", 4, 19, "field.rate.1", "allowed: [0, 1000] 1/s"},
    {"FieldWithoutFluid", CLOTH "field: {rate: [1, 1, 0]}\n", 4, 8, "field", "acts on liquid"},
    {"GravityIsANumber", FLUID "gravity: -9.81\n", 4, 10, "gravity", "a list of 3 numbers in [-1000, 1000] m/s²"},
    {"GravityIsShort", FLUID "gravity: [0, -9.81]\n", 4, 10, "gravity", "is a list of 2; allowed: a list of 3"},
    {"GravityHasAWord", FLUID "gravity: [0, down, 0]\n", 4, 14, "gravity.1", "'down' is not a number"},
    {"GravityIsInfinite", FLUID "gravity: [0, -.inf, 0]\n", 4, 14, "gravity.1", "is not a finite double"},
    {"DomainIsFlat", FLUID "domain: {min: [0, 0, 0], max: [1, 0, 1]}\n", 4, 35, "domain.max.1",
     "0 is not above min (0)"},
    {"DomainHalfGiven", FLUID "domain: {min: [0, 0, 0]}\n", 4, 9, "domain.max", "is missing; allowed: a list of 3"},
    {"DomainIsHuge", FLUID "domain: {min: [0, 0, 0], max: [1, 1e9, 1]}\n", 4, 35, "domain.max.1", "[-10000, 10000] m"},
    {"OutputIsNegative", FLUID "output: {every: -0.1}\n", 4, 17, "output.every", "allowed: [0, 1e6] s"},
    {"Checkpoints", FLUID "output: {checkpoint_every: 1}\n", 4, 28, "output.checkpoint_every",
     "writing checkpoints is not available in this version; allowed: 0 s"},
    {"SortRadix", FLUID "neighbors: {sort: radix}\n", 4, 19, "neighbors.sort",
     "'radix' is not available in this version; allowed: auto, counting"},
    {"SortBitonic", FLUID "neighbors: {sort: bitonic}\n", 4, 19, "neighbors.sort", "'bitonic' is not available"},
    // fluid
    {"FluidKeyMisspelt", FLUID "  spaceing: 0.01\n", 4, 3, "fluid.spaceing", "did you mean 'spacing'?"},
    {"FluidKeySwapped", FLUID "  desnity: 1000\n", 4, 3, "fluid.desnity", "did you mean 'density'?"},
    {"SpacingIsNegative", FLUID "  spacing: -1\n", 4, 12, "fluid.spacing", "'-1' is out of range; allowed: (0, 10] m"},
    {"DensityInGrams", FLUID "  density: 0.998\n", 4, 12, "fluid.density", "allowed: [1, 30000] kg/m³"},
    {"ViscosityIsNegative", FLUID "  viscosity: -1e-6\n", 4, 14, "fluid.viscosity", "allowed: [0, 100] m²/s"},
    {"SurfaceTensionInMillis", FLUID "  surface_tension: 72\n", 4, 20, "fluid.surface_tension", "allowed: [0, 10] N/m"},
    {"KernelMisspelt", FLUID "  kernel: wenland\n", 4, 11, "fluid.kernel",
     "did you mean 'wendland'? allowed: cubic, wendland, poly6"},
    {"SupportIsSmall", FLUID "  support: 1.7\n", 4, 12, "fluid.support", "allowed: [1.8, 4] spacings"},
    {"IterationsAreHalf", FLUID "  solver: {max_iterations: 2.5}\n", 4, 28, "fluid.solver.max_iterations",
     "'2.5' is not a whole number; allowed: [1, 100000] iterations"},
    {"IterationsOverflow", FLUID "  solver: {max_iterations: 99999999999}\n", 4, 28, "fluid.solver.max_iterations",
     "is out of range"},
    {"IterationsCross", FLUID "  solver: {max_iterations: 5, min_iterations: 6}\n", 4, 47,
     "fluid.solver.min_iterations", "min_iterations (6) is above max_iterations (5)"},
    {"NoSources", HEAD "fluid:\n  spacing: 0.1\n", 3, 3, "fluid.sources", "is missing; allowed: a list of maps"},
    {"EmptySources", HEAD "fluid: {sources: []}\n", 2, 18, "fluid.sources", "is an empty list"},
    {"SourcesIsAMap", HEAD "fluid: {sources: {block: {}}}\n", 2, 18, "fluid.sources", "is a map; allowed: a list"},
    {"SourceUnknown", SOURCES "    - blok: {}\n", 4, 7, "fluid.sources.0.blok", "did you mean 'block'?"},
    {"SourceIsTwo", SOURCES "    - {block: {}, jet: {}}\n", 4, 7, "fluid.sources.0", "has 2 of the keys block, jet"},
    {"SourceIsNone", SOURCES "    - {}\n", 4, 7, "fluid.sources.0", "has none of the keys block, jet"},
    {"BlockWithoutMax", SOURCES "    - block: {min: [0, 0, 0]}\n", 4, 14, "fluid.sources.0.block.max", "is missing"},
    {"BlockInsideOut", SOURCES "    - block: {min: [0, 0, 2], max: [1, 1, 1]}\n", 4, 43, "fluid.sources.0.block.max.2",
     "1 is not above min (2); allowed: more than min, in m"},
    {"JetStandsStill", SOURCES "    - jet: {center: [0, 0, 0], radius: 1, velocity: [0, 0, 0]}\n", 4, 53,
     "fluid.sources.0.jet.velocity", "has length 0"},
    {"JetEndsFirst", SOURCES "    - jet: {center: [0, 0, 0], radius: 1, velocity: [0, 1, 0], start: 2, end: 1}\n", 4,
     79, "fluid.sources.0.jet.end", "an end after the start"},
    {"JetStartsNever", SOURCES "    - jet: {center: [0, 0, 0], radius: 1, velocity: [0, 1, 0], start: .inf}\n", 4, 71,
     "fluid.sources.0.jet.start", "is not a finite double; allowed: [0, 1e6] s"},
    {"JetWithoutRadius", SOURCES "    - jet: {center: [0, 0, 0], velocity: [0, 1, 0]}\n", 4, 12,
     "fluid.sources.0.jet.radius", "is missing; allowed: a number in (0, 100] m"},
    {"UnknownBeforeMissing", SOURCES "    - jet: {centre: [0, 0, 0]}\n", 4, 13, "fluid.sources.0.jet.centre",
     "did you mean 'center'?"},
    // cloth
    {"EmptyCloths", FLUID "cloth: []\n", 4, 8, "cloth", "is an empty list"},
    {"ClothIsAMap", HEAD "cloth: {mesh: {grid: {}}}\n", 2, 8, "cloth", "is a map; allowed: a list"},
    {"ClothWithoutMesh", HEAD "cloth:\n  - name: sheet\n", 3, 5, "cloth.0.mesh", "is missing; allowed: a map"},
    {"MeshOfNothing", HEAD "cloth: [{mesh: {}}]\n", 2, 16, "cloth.0.mesh.grid", "neither grid nor file"},
    {"MeshOfBoth", HEAD "cloth: [{mesh: {grid: {}, file: exists.obj}}]\n", 2, 33, "cloth.0.mesh.file", "beside grid"},
    {"GridScaled", HEAD "cloth: [{mesh: {grid: {}, scale: 2}}]\n", 2, 34, "cloth.0.mesh.scale", "is for mesh files"},
    {"GridOfOneRow", HEAD "cloth: [{mesh: {grid: {nodes: [1, 5]}}}]\n", 2, 32, "cloth.0.mesh.grid.nodes.0",
     "'1' is out of range; allowed: [2, 4096] nodes"},
    {"GridIsHuge", HEAD "cloth: [{mesh: {grid: {nodes: [5, 4097]}}}]\n", 2, 35, "cloth.0.mesh.grid.nodes.1", "4096"},
    {"GridWithoutWidth", HEAD "cloth: [{mesh: {grid: {size: [0, 1]}}}]\n", 2, 31, "cloth.0.mesh.grid.size.0",
     "allowed: (0, 1000] m"},
    {"MeshFileMissing", HEAD "cloth: [{mesh: {file: shirt.obj}}]\n", 2, 23, "cloth.0.mesh.file", "there is no file"},
    {"MeshFileUnknown", HEAD "cloth: [{mesh: {file: shirt.fbx}}]\n", 2, 23, "cloth.0.mesh.file",
     "'shirt.fbx' is not a mesh file that can be read; allowed: .obj, .ply, .stl"},
    {"MeshFileIsAFolder", HEAD "cloth: [{mesh: {file: folder.obj}}]\n", 2, 23, "cloth.0.mesh.file", "is not a file"},
    {"ClothAdhesionIsHuge", CLOTH "    adhesion: 11\n", 4, 15, "cloth.0.adhesion", "allowed: [0, 10] N/m"},
    {"ClothNameIsEmpty", CLOTH "    name: \"\"\n", 4, 11, "cloth.0.name", "a text of 1 to 100 bytes"},
    {"ClothNameHasALineBreak", CLOTH "    name: \"a\\nb\"\n", 4, 11, "cloth.0.name", "without control characters"},
    {"SameNameTwice", CLOTH "    name: a\n  - {mesh: {grid: {}}, name: a}\n", 5, 30, "cloth.1.name",
     "named 'a' too; allowed: a name of its own"},
    {"NoNameTwice", CLOTH "  - mesh: {grid: {}}\n", 4, 5, "cloth.1.name", "named 'cloth' too"},
    {"RotateWithoutAxis", CLOTH "    place: {rotate: {axis: [0, 0, 0]}}\n", 4, 28, "cloth.0.place.rotate.axis",
     "has length 0"},
    {"PositionIsLong", CLOTH "    place: {position: [0, 0, 0, 0]}\n", 4, 23, "cloth.0.place.position", "a list of 4"},
    {"NoArealDensity", CLOTH "    areal_density: 0\n", 4, 20, "cloth.0.areal_density", "allowed: (0, 1000] kg/m²"},
    {"ThicknessInMillimetres", CLOTH "    thickness: 1.2\n", 4, 16, "cloth.0.thickness", "allowed: (0, 1] m"},
    {"StretchIsNegative", CLOTH "    stretch: -5\n", 4, 14, "cloth.0.stretch", "allowed: (0, 1e9] N/m"},
    {"FrictionIsHexadecimal", CLOTH "    friction: 0x1\n", 4, 15, "cloth.0.friction", "is not a number"},
    {"DynamicsIsAWord", CLOTH "    dynamics: perhaps\n", 4, 15, "cloth.0.dynamics", "allowed: true, false"},
    {"SelfCollisionIsAWord", CLOTH "    self_collision: perhaps\n", 4, 21, "cloth.0.self_collision",
     "allowed: true, false"},
    {"EmptyPins", CLOTH "    pin: []\n", 4, 10, "cloth.0.pin", "is an empty list"},
    {"PinUnknown", CLOTH "    pin: [{corner: true}]\n", 4, 12, "cloth.0.pin.0.corner", "did you mean 'corners'?"},
    {"PinSwitchedOff", CLOTH "    pin: [{edges: false}]\n", 4, 19, "cloth.0.pin.0.edges", "is false; allowed: true"},
    {"PinNodesEmpty", CLOTH "    pin: [{nodes: []}]\n", 4, 19, "cloth.0.pin.0.nodes", "is an empty list"},
    {"PinNodeNegative", CLOTH "    pin: [{nodes: [0, -1]}]\n", 4, 23, "cloth.0.pin.0.nodes.1", "is out of range"},
    {"PinNodeNotInGrid", CLOTH "    pin: [{nodes: [0, 25]}]\n", 4, 23, "cloth.0.pin.0.nodes.1", "allowed: [0, 24]"},
    {"SaturationOfNothing", CLOTH "    initial_saturation: [{box: {min: [0, 0, 0], max: [1, 1, 1]}, value: 1}]\n", 4,
     25, "cloth.0.initial_saturation", "allowed: only beside the key porous"},
    {"SaturationTooHigh",
     CLOTH "    porous: {}\n    hold_saturation: [{box: {min: [0, 0, 0], max: [1, 1, 1]}, value: 1.5}]\n", 5, 70,
     "cloth.0.hold_saturation.0.value", "1.5 is above porous.max_saturation; allowed: [0, 1.18]"},
    {"SaturationWithoutValue", CLOTH "    hold_saturation: [{box: {min: [0, 0, 0], max: [1, 1, 1]}}]\n", 4, 23,
     "cloth.0.hold_saturation.0.value", "is missing; allowed: a number in [0, 10] (no unit)"},
    {"AllSolid", CLOTH "    porous: {solid_fraction: 1}\n", 4, 30, "cloth.0.porous.solid_fraction",
     "allowed: [0, 1) (no unit)"},
    {"MaxSaturationIsLow", CLOTH "    porous: {max_saturation: 0.9}\n", 4, 30, "cloth.0.porous.max_saturation",
     "allowed: [1, 10]"},
    {"EmissionAngleIsFlat", CLOTH "    porous: {emission_angle: 180}\n", 4, 30, "cloth.0.porous.emission_angle",
     "allowed: (0, 180) degrees"},
    {"DiffusionMisspelt", CLOTH "    porous: {diffusion: degenrate}\n", 4, 25, "cloth.0.porous.diffusion",
     "did you mean 'degenerate'? allowed: linear, degenerate"},
    {"Adhesion", CLOTH "    porous: {adhesion: 0.1}\n", 4, 24, "cloth.0.porous.adhesion",
     "wet adhesion is not available in this version; allowed: 0"},
    // bodies
    {"EmptyBodies", FLUID "bodies: []\n", 4, 9, "bodies", "is an empty list"},
    {"BodyUnknown", BODIES "  - cylinder: {}\n", 5, 5, "bodies.0.cylinder", "allowed: box, sphere, plane, mesh"},
    {"BodyIsAWord", BODIES "  - box\n", 5, 5, "bodies.0", "is 'box'; allowed: a map"},
    {"BodyBoxInsideOut", BODIES "  - box: {min: [1, 0, 0], max: [0, 1, 1]}\n", 5, 33, "bodies.0.box.max.0",
     "0 is not above min (1)"},
    {"BoxInsideIsANumber", BODIES "  - box: {min: [0, 0, 0], max: [1, 1, 1], inside: 1}\n", 5, 51,
     "bodies.0.box.inside", "'1' is not a truth value"},
    {"SphereWithoutRadius", BODIES "  - sphere: {center: [0, 0, 0]}\n", 5, 13, "bodies.0.sphere.radius", "is missing"},
    {"SphereIsAPoint", BODIES "  - sphere: {center: [0, 0, 0], radius: 0}\n", 5, 41, "bodies.0.sphere.radius",
     "allowed: (0, 10000] m"},
    {"BodyAdhesionIsNegative", BODIES "  - sphere: {center: [0, 0, 0], radius: 1, adhesion: -1}\n", 5, 54,
     "bodies.0.sphere.adhesion", "allowed: [0, 10] N/m"},
    {"PlaneWithoutNormal", BODIES "  - plane: {point: [0, 0, 0], normal: [0, -0, 0]}\n", 5, 39, "bodies.0.plane.normal",
     "has length 0; allowed: a vector that points somewhere"},
    {"BodyMeshMissing", BODIES "  - mesh: {file: bunny.obj}\n", 5, 18, "bodies.0.mesh.file", "there is no file"},
    {"BodyMeshWithoutFile", BODIES "  - mesh: {scale: 2}\n", 5, 11, "bodies.0.mesh.file",
     "is missing; allowed: the name of an .obj, .ply or .stl file"},
    {"SpinWithoutAxis", BODIES "  - mesh: {file: exists.obj, spin: {axis: [0, 0, 0]}}\n", 5, 43,
     "bodies.0.mesh.spin.axis", "has length 0"},
    {"BodyIsTooFast", BODIES "  - sphere: {center: [0, 0, 0], radius: 1, velocity: [0, 2000, 0]}\n", 5, 58,
     "bodies.0.sphere.velocity.1", "'2000' is out of range; allowed: [-1000, 1000] m/s"},
    {"SphereSpinsAboutNothing", BODIES "  - sphere: {center: [0, 0, 0], radius: 1, spin: {axis: [0, 0, 0]}}\n", 5, 57,
     "bodies.0.sphere.spin.axis", "has length 0"},
    {"DensityOfAFixedBody", BODIES "  - sphere: {center: [0, 0, 0], radius: 1, density: 500}\n", 5, 53,
     "bodies.0.sphere.density", "is for a body that floats; allowed: only beside dynamic: true"},
    {"DensityOfAir", BODIES "  - sphere: {center: [0, 0, 0], radius: 1, dynamic: true, density: 0.5}\n", 5, 68,
     "bodies.0.sphere.density", "'0.5' is out of range; allowed: [1, 30000] kg/m³"},
    {"FloatingPlane", BODIES "  - plane: {point: [0, 0, 0], normal: [0, 1, 0], dynamic: true}\n", 5, 59,
     "bodies.0.plane.dynamic", "allowed: false, or a sphere or a box that is not a container"},
    {"FloatingMesh", BODIES "  - mesh: {file: exists.obj, dynamic: true}\n", 5, 39, "bodies.0.mesh.dynamic",
     "a plane, mesh or container that the liquid moves is not available in this version"},
    {"FloatingContainer", BODIES "  - box: {min: [0, 0, 0], max: [1, 1, 1], inside: true, dynamic: true}\n", 5, 66,
     "bodies.0.box.dynamic", "allowed: false, or a sphere or a box that is not a container"},
    {"FloatingOnNothing", CLOTH "bodies:\n  - sphere: {center: [0, 0, 0], radius: 1, dynamic: true}\n", 5, 53,
     "bodies.0.sphere.dynamic", "a dynamic body in a scene without fluid is not available in this version"},
};

#undef HEAD
#undef FLUID
#undef CLOTH
#undef SOURCES
#undef BODIES

struct BadOverride {
  const char* name;
  const char* override_text;
  const char* message;  // the whole of it
};

/// On a scene with one fluid block and one cloth.
inline constexpr BadOverride bad_overrides[] = {
    {"OutOfRange", "fluid.spacing=-1",
     "--set fluid.spacing=-1: fluid.spacing: '-1' is out of range; allowed: (0, 10] m"},
    {"UnknownKey", "fluid.spaceing=1",
     "--set fluid.spaceing=1: fluid.spaceing: unknown key 'spaceing' in fluid; did you mean 'spacing'?"},
    {"UnknownKeyInANewMap", "output.evry=1",
     "--set output.evry=1: output.evry: unknown key 'evry' in output; did you mean 'every'?"},
    {"NoSuchEntry", "cloth.1.bend=1", "--set cloth.1.bend=1: cloth: has no entry '1'; allowed: 0 to 0"},
    {"EntryIsAWord", "cloth.sheet.bend=1", "--set cloth.sheet.bend=1: cloth: has no entry 'sheet'; allowed: 0 to 0"},
    {"ThroughAValue", "drench.x=1", "--set drench.x=1: drench: has no key 'x', it is the value '1'"},
    {"NoEquals", "fluid.spacing", "--set fluid.spacing: cannot be understood; allowed: key.path=value"},
    {"NoKey", "=1", "--set =1: cannot be understood; allowed: key.path=value"},
    {"EmptyPart", "fluid..spacing=1", "--set fluid..spacing=1: cannot be understood; allowed: key.path=value"},
    {"NoValue", "fluid.spacing=", "--set fluid.spacing=: fluid.spacing: nothing is not a number; allowed: (0, 10] m"},
    {"BadElement", "gravity=[0, a, 0]",
     "--set gravity=[0, a, 0]: gravity.1: 'a' is not a number; allowed: [-1000, 1000] m/s²"},
    {"LineBreak", "fluid.spacing=a\nb",
     "--set fluid.spacing=a\\x0ab: fluid.spacing: 'a b' is not a number; allowed: (0, 10] m"},
};

}  // namespace drench::testing
