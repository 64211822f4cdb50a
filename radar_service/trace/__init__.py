"""What rays hit and what hides what: Embree, Moeller-Trumbore, line of sight, ray sampling."""
