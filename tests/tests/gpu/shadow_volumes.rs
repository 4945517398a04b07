//! Stencil shadow volumes: the meshes of real scenes have adjacency, without a driver.

mod assets;
