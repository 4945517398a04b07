// The number of the instance: a vertex attribute of 0, 1, 2, ... by instance, from the first
// instance of a draw on. Vertex shaders of indirect draws read it in place of gl_InstanceIndex:
// some hardware walks a list of draws by itself only where no shader needs the base instance.
// Mirrors `NUMBER_LOCATION` of the crate `gpu`.
layout(location = 7) in uint instance_number;
