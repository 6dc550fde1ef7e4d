"""What the site is made of besides the pages: settings of Sphinx, gallery, reference, check of links."""
